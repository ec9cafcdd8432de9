"""Answers to a set: one gap report for each case, and their hashes when all are there.

A solver is a function from the folder of a case and the names that may not be suspected to a gap
report as plain data. Ours is the diagnosis of this package; `FILE.py:function` is anybody's.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from analysis.gap.report import FORMAT as GAP_FORMAT
from analysis.gap.report import NO_GAP, VERDICTS, GapReport
from camtruth.blind.errors import BlindError
from camtruth.blind.format import CASES, NOMINAL, CaseEntry, SetDocument, read_set
from foundation.errors import InputError, unknown
from foundation.jobs import fingerprint, run
from foundation.output import new_file
from foundation.resumable import resumable_folder
from foundation.users_code import users_code, users_module

Solver = Callable[[Path, tuple[str, ...]], dict[str, Any]]
EXPECTED = "expected a function (folder, without) that returns a gap report as a dict"

OURS = "diagnose"


def diagnose(folder: Path, without: tuple[str, ...]) -> dict[str, Any]:
    """This package's diagnosis, told the camera's data sheet.

    A capture that it refuses is one that it has no answer to: "insufficient data", with the reason.
    """
    from camtruth.diagnosing import diagnosis

    sheet = folder / NOMINAL
    model = str(sheet) if sheet.is_file() else None
    try:
        return diagnosis(folder, model, without=without).report.to_json()
    except InputError as refusal:
        refused = GapReport(verdict="insufficient data", gap=NO_GAP, notes=(str(refusal),))
        return refused.to_json()


def solver_of(name: str) -> Solver:
    """A solver by its name, or from a user's file as `FILE.py:function`.

    Raises:
        BlindError: when there is none.
    """
    from camtruth.blind import baselines

    ours: dict[str, Solver] = {
        OURS: diagnose,
        "histogram": baselines.histogram,
        "refit-free": baselines.refit_free,
    }
    if name in ours:
        return ours[name]
    file, colon, function = name.rpartition(":")
    if not (colon and file.endswith(".py") and function):
        raise unknown("solver", name, [*ours, "FILE.py:function"], BlindError)
    return _users(Path(file), function)


def _users(path: Path, function: str) -> Solver:
    module = users_module(path, "expected a Python file with a solver", BlindError)
    found = getattr(module, function, None)
    if not callable(found):
        raise BlindError(f"no function '{function}' in {path}", EXPECTED, "write it")
    try:
        inspect.signature(found).bind(None, None)
    except (TypeError, ValueError):
        raise BlindError(
            f"'{function}' in {path} cannot be called with two arguments",
            EXPECTED,
            f"write it as 'def {function}(folder, without):'",
        ) from None

    def solver(folder: Path, without: tuple[str, ...]) -> dict[str, Any]:
        with users_code(path):
            return found(folder, without)  # type: ignore[no-any-return]

    return solver


def checked(found: Any, source: str) -> dict[str, Any]:
    """A gap report that can be scored.

    Raises:
        BlindError: for what is none.
    """
    if not isinstance(found, dict) or found.get("format") != GAP_FORMAT:
        raise BlindError(f"{source} is no gap report", f"expected format {GAP_FORMAT}", "see there")
    if found.get("verdict") not in VERDICTS:
        raise unknown("verdict", str(found.get("verdict")), VERDICTS, BlindError)
    effects = found.get("effects")
    fit = isinstance(effects, list) and all(
        isinstance(e, dict)
        and isinstance(e.get("name"), str)
        and isinstance(e.get("probability"), (int, float))
        and 0 <= e["probability"] <= 1
        and _few_names(e.get("indistinguishable_from", []))
        for e in effects
    )
    if not fit:
        raise BlindError(
            f"the effects in {source}",
            "expected a list of tables with name, probability (0 to 1) and at most two names in"
            " indistinguishable_from",
            f"see the format {GAP_FORMAT}",
        )
    return found


def _few_names(names: Any) -> bool:
    return isinstance(names, list) and len(names) <= 2 and all(isinstance(n, str) for n in names)


def solve(
    folder: Path,
    out: Path,
    *,
    solver: str = OURS,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] = lambda cases: None,
) -> SetDocument:
    """Answer every case of a set into `out`, which is hashed when it is whole.

    Args:
        folder: the set.
        out: of the answers.
        solver: see `solver_of`.
        resume, overwrite: as everywhere.
        scheduler: of a cluster whose machines see both folders at the same paths.
        threads: cases at once in this process.
        progress: told the number of cases done.

    Raises:
        InputError: for a set that is none, a solver that fails, a place that is taken.
    """
    document = read_set(folder)
    known = solver_of(solver)
    del known  # workers load it themselves; here it was only checked
    question = json.dumps([document.commitment, solver, fingerprint()])
    with resumable_folder(out, question, resume=resume, overwrite=overwrite) as work:
        cases = {
            case.name: (str((folder / CASES).resolve()), str(work.resolve()), solver, case)
            for case in document.case
        }
        missing = {name: case for name, case in cases.items() if not _file(work, name).exists()}
        progress(len(cases) - len(missing))
        run(answer, missing, scheduler=scheduler, threads=threads, progress=progress)
    return document


def answer(shared: None, case: tuple[str, str, str, CaseEntry]) -> None:
    """Write one case's gap report."""
    cases, work, name, entry = case
    try:
        found = solver_of(name)(Path(cases) / entry.name, entry.without)
        text = json.dumps(checked(found, f"the answer to {entry.name}"), indent=1, allow_nan=False)
    except InputError:
        raise
    except Exception as problem:
        raise BlindError(
            f"solver '{name}' raised {type(problem).__name__} on case {entry.name}: {problem}",
            EXPECTED,
            "mend it, then run it again with --resume",
        ) from problem
    with new_file(_file(Path(work), entry.name)) as scratch:
        scratch.write_text(text + "\n", encoding="utf-8")


def _file(folder: Path, name: str) -> Path:
    return folder / f"{name}.json"


def read_answers(folder: Path, names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Every answer by case, if all are there and as they were when they were hashed.

    Raises:
        BlindError: when one is missing, no gap report, or none is hashed.
        DamageError: when one was changed after it was hashed.
    """
    from foundation.documents import parse_json, read_text
    from foundation.output import CHECKSUMS
    from foundation.verification import verify

    if not folder.is_dir():
        raise BlindError(
            f"no answers {folder}",
            "expected a gap report for each case",
            "run 'camtruth blind solve', or name them with --answers",
        )
    absent = [name for name in names if not _file(folder, name).is_file()]
    if absent:
        raise BlindError(
            f"{len(absent)} cases without an answer in {folder}, {absent[0]} among them",
            "expected all before the seal is opened",
            "answer them: 'matched' and 'unexplained' are answers",
        )
    if not (folder / CHECKSUMS).is_file():
        raise BlindError(
            f"no {CHECKSUMS} in {folder}",
            "expected the answers' hashes before the seal is opened",
            f"run 'sha256sum *.json > {CHECKSUMS}' there",
        )
    verify(folder)
    found = {}
    for name in names:
        path = _file(folder, name)
        found[name] = checked(parse_json(read_text(path), str(path)), str(path))
    return found
