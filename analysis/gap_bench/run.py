"""The bench as files in a folder: light, detection limits, and one line for each case.

    light-160x120/rate-<lamp>.exr        rendered once
    limits-160x120x24-<code>.json        once for each size
    cases-160x120x24-seed0-<code>.jsonl  one line a case; <code> changes with the diagnosis

Results of two versions of the diagnosis never stand in one file.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import analysis.gap
import analysis.identifiability
from analysis.gap.diagnose import diagnose
from analysis.gap.look.shots import GROUP_FRAMES, MOST_GROUPS
from analysis.gap_bench.cases import all_cases, suspects
from analysis.gap_bench.draw import middle
from analysis.gap_bench.examine import Bench, Diagnose, examine
from analysis.gap_bench.severity import fit_of, limits_of
from analysis.identifiability.known import small_light
from analysis.identifiability.limits import Limit, default_of, limits
from foundation.documents import parse_json
from foundation.errors import InputError
from foundation.jobs import run
from foundation.output import new_file
from render.rate import RateImage, read_rate, write_rate
from scenes import scene as scenes
from sensor.catalogue import effect

SCENE = "chart"
FORMAT = "camtruth-gap-bench/1"

PIECE = 12
"""Cases for each worker between two looks at the clock: at its end some of them wait for others."""

Say = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a bench lies, how large its captures are, and which cameras it draws."""

    out: Path
    width: int = 160
    height: int = 120
    frames: int = 24
    seed: int = 0

    @property
    def size(self) -> str:
        """Size of a capture in words, as in 160x120x24."""
        return f"{self.width}x{self.height}x{self.frames}"

    @property
    def results(self) -> Path:
        """The file of the cases, for the code that stands here."""
        return self.out / f"cases-{self.size}-seed{self.seed}-{code()}.jsonl"

    @property
    def limits(self) -> Path:
        """The file of the detection limits, for the code that stands here."""
        return self.out / f"limits-{self.size}-{code()}.json"


def code() -> str:
    """A short name of the diagnosis, and of the limits that cases are measured by, as their files
    stand: it changes with any of them."""
    digest = hashlib.sha256()
    for package in (analysis.gap, analysis.identifiability):
        folder = Path(package.__path__[0])
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.relative_to(folder.parent).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:8]


def question(place: Place) -> str:
    """What decides the results of a place besides the code."""
    return f"gap bench {place.size} seed {place.seed}"


def light(place: Place) -> dict[str, RateImage]:
    """The rate images of the bench by lamp, rendered when they are first asked for."""
    folder = place.out / f"light-{place.width}x{place.height}"
    lamps = scenes.load(SCENE).lamp_names
    if not all((folder / f"rate-{lamp}.exr").is_file() for lamp in lamps):
        folder.mkdir(parents=True, exist_ok=True)
        for lamp, image in small_light(SCENE, place.width, place.height).items():
            write_rate(folder / f"rate-{lamp}.exr", image)
    return {lamp: read_rate(folder / f"rate-{lamp}.exr") for lamp in lamps}


def known_limits(place: Place, images: Mapping[str, RateImage], say: Say) -> dict[str, Limit]:
    """The detection limits of the camera in the middle, found when they are first asked for."""
    found = read_limits(place.limits) if place.limits.is_file() else {}
    missing = [name for name in suspects() if name not in found]
    if missing:
        known, groups = fit_of(middle(place.height, place.width), images, place.frames)
        for name in missing:
            say(f"detection limit of {name}")
            found |= limits(known, groups, [default_of(effect(name))])
            write_limits(place, found)
    return {name: found[name] for name in suspects()}


def write_limits(place: Place, found: Mapping[str, Limit]) -> None:
    """Keep detection limits."""
    document = {
        "format": FORMAT,
        "size": place.size,
        "limits": {name: dataclasses.asdict(limit) for name, limit in sorted(found.items())},
    }
    place.out.mkdir(parents=True, exist_ok=True)
    with new_file(place.limits) as scratch:
        scratch.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def read_limits(path: Path) -> dict[str, Limit]:
    """Detection limits from their file."""
    if not path.is_file():
        raise InputError(
            f"no detection limits {path}",
            "expected those of a bench",
            "run 'python -m analysis.gap_bench limits' first",
        )
    document = json.loads(path.read_text(encoding="utf-8"))
    return {name: Limit(**entry) for name, entry in document["limits"].items()}


def run_bench(
    place: Place,
    *,
    count: int | None = None,
    kind: str | None = None,
    case: str | None = None,
    unfitted: bool = True,
    minutes: float | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    say: Say = print,
    diagnosis: Diagnose = diagnose,
) -> list[dict[str, Any]]:
    """Diagnose the first cases of the shuffled order; what is done already is not done again.

    Args:
        place: where, and how large.
        count: how many of the cases; all by default.
        kind: only nulls, effects, withheld effects or pairs.
        case: only the one of this name.
        unfitted: judge nulls without calibration as well.
        minutes: begin no case after so many.
        workers: cases at once.
        scheduler: address of a Dask scheduler, or `PROCESSES`; this process by default.
        say: told what is done.
        diagnosis: what is examined.

    Raises:
        InputError: for too few frames, or a case that there is not.
    """
    if place.frames < 2 * GROUP_FRAMES:
        raise InputError(
            f"{place.frames} frames of each shot",
            f"expected {2 * GROUP_FRAMES} to {MOST_GROUPS * GROUP_FRAMES}",
            "give more with --frames",
        )
    images = light(place)
    known_limits(place, images, say)
    bench = Bench(
        light=images,
        limits=functools.partial(limits_of, images, place.frames),
        frames=place.frames,
        unfitted=unfitted,
        diagnosis=diagnosis,
    )
    chosen = all_cases(bench_seed=place.seed)
    if kind is not None:
        chosen = {key: case for key, case in chosen.items() if case.kind == kind}
    if case is not None:
        if case not in chosen:
            raise InputError(
                f"no case '{case}'",
                f"expected one of {len(chosen)}, as {next(iter(chosen))}",
                "name it by kind, effects, limits and number",
            )
        chosen = {case: chosen[case]}
    keys = list(chosen)[:count]
    began, done = time.monotonic(), 0

    def progress(more: int) -> None:
        nonlocal done
        done += more
        if more:
            say(f"{done} of {len(keys)} cases, {time.monotonic() - began:.0f} s")

    # piece by piece, so that the time can be watched between them
    results: dict[str, dict[str, Any]] = {}
    piece = max(len(keys), 1)
    if minutes is not None:
        piece = 1 if workers == 1 and scheduler is None else PIECE * workers
    for start in range(0, len(keys), piece):
        if minutes is not None and time.monotonic() - began > 60 * minutes:
            break
        results |= run(
            examine,
            {key: chosen[key] for key in keys[start : start + piece]},
            shared=bench,
            scheduler=scheduler,
            threads=workers,
            journal=place.results,
            question=question(place),
            progress=progress,
        )
    return [{"case": key, **row} for key, row in results.items()]


def read_results(path: Path) -> list[dict[str, Any]]:
    """All cases in a file of results, in the order they were done."""
    if not path.is_file():
        raise InputError(
            f"no results {path}", "expected those of a bench", "run 'make bench-gap' first"
        )
    entries = [
        parse_json(line, str(path)) for line in path.read_text(encoding="utf-8").splitlines()
    ]
    return [{"case": entry["key"], **entry["result"]} for entry in entries if "result" in entry]


def latest(place: Place) -> Path | None:
    """The file of results of such captures that was written last."""
    like = f"cases-{place.size}-seed{place.seed}-*.jsonl"
    files = sorted(place.out.glob(like), key=lambda path: path.stat().st_mtime)
    return files[-1] if files else None
