"""A folder that takes long to fill: what is done survives a kill, and shows itself only when whole.

It is filled beside its place, as ``NAME.unfinished``, piece by piece, each piece atomic. A run that
was stopped leaves it there, and one with `resume` goes on in it; when all is done it is checksummed
and moved into place. What was asked is noted in it, so that answers to two questions never mix.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from foundation.claim import claim
from foundation.errors import InputError, OutputError
from foundation.output import refuse_taken, write_checksums

QUESTION = ".question"
LOCK = ".lock"


def unfinished(path: Path) -> Path:
    """Where a folder is filled before it is whole."""
    return path.with_name(f"{path.name}.unfinished")


@contextlib.contextmanager
def resumable_folder(
    path: Path,
    question: str,
    *,
    resume: bool = False,
    overwrite: bool = False,
    keep_refused: bool = True,
) -> Iterator[Path]:
    """A folder to fill, kept when the block fails, moved to `path` when it ends well.

    Args:
        path: where it will stand.
        question: what is asked for, such as a specification and versions.
        resume: go on with what a run of the same question left.
        overwrite: throw away what stands there, finished or not.
        keep_refused: keep it when the block refuses its input too; False where such input can only
            be mended, which is another question.

    Raises:
        OutputError: when the place is taken, in use, cannot be written, or holds another question.
    """
    work = unfinished(path)
    refuse_taken(path, overwrite=overwrite)
    if work.exists() and overwrite and not resume:
        with _locked(work):
            shutil.rmtree(work)
    if work.exists() and not resume:
        raise OutputError(
            f"{work} holds a run that was not finished",
            "expected none",
            "go on with it by --resume, or start anew by --overwrite",
        )
    try:
        work.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise _unwritable(work, problem) from None
    with _locked(work):
        _note(work, question)
        _sweep(work)
        try:
            yield work
            (work / QUESTION).unlink()
            (work / LOCK).unlink()
            write_checksums(work)
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            work.replace(path)
        except OSError as problem:
            raise _unwritable(work, problem) from None
        except InputError as problem:
            if not keep_refused and not isinstance(problem, OutputError):
                shutil.rmtree(work, ignore_errors=True)
            raise


def _unwritable(path: Path, problem: OSError) -> OutputError:
    return OutputError(
        f"cannot write {path} ({problem.strerror or problem})",
        "expected a place that can be written",
        "make room or choose another --out, then run it again with --resume",
    )


def _note(work: Path, question: str) -> None:
    """Write down what is asked, or compare with what was."""
    note = work / QUESTION
    known = note.read_text(encoding="utf-8") if note.exists() else None
    if known not in (None, question):
        raise OutputError(
            f"{work} answers another question",
            "expected the same specification, seeds and versions as before",
            "give those of the first run, or start anew by --overwrite without --resume",
        )
    if known is None:
        scratch = work / f"{QUESTION}-new"
        scratch.write_text(question, encoding="utf-8")
        scratch.replace(note)


def _sweep(work: Path) -> None:
    """Remove the half-written pieces of a run that was killed: their names begin with a dot."""
    for root, folders, files in os.walk(work):
        for name in [name for name in folders if name.startswith(".")]:
            shutil.rmtree(Path(root) / name, ignore_errors=True)
            folders.remove(name)
        for name in files:
            if name.startswith(".") and name not in (QUESTION, LOCK):
                (Path(root) / name).unlink(missing_ok=True)


@contextlib.contextmanager
def _locked(work: Path) -> Iterator[None]:
    """One run at a time; the lock of a process that was killed is free."""
    with (work / LOCK).open("w") as stream:
        claim(stream, work)
        yield
