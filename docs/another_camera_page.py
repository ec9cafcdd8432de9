"""What the diagnosis says of a camera by somebody else, fault by fault, and the page of it.

    python -m docs.another_camera_page [--pixels rgb8] [--seed 46] [--strength 1]

Captures and answers stay in camtruth-out/another-camera, and what is there is not done again.
"""

from __future__ import annotations

import argparse
import functools
import json
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from docs.examples.another_camera import KINDS
from foundation.cores import cores
from foundation.output import new_file

CAMTRUTH = Path(sys.executable).with_name("camtruth")
HERE = Path(__file__).parent
SCRIPT = "docs.examples.another_camera"
WORK = HERE.parent / "camtruth-out" / "another-camera"
TEXT = HERE / "another_camera_text.md"
RESULTS = HERE / "results" / "another-camera"
PAGE = HERE / "another-camera.md"

MOSAICS = ("RGGB", "GRBG", "GBRG", "BGGR")
"""Of one fault after the other."""

PATHS = 288
"""Light paths a pixel: four times those of `camtruth render`, and of another seed."""


HEADINGS = {
    "rgb8": "Colours, 8 bits",
    "bayer16": "Raw, 12 bits",
    "mono16": "Grey, 12 bits, even light that nobody states",
}
"""Of the cameras by what they send."""


def answered(fault: str, strength: float, seed: int, pixels: str) -> dict[str, Any]:
    """The gap report of one fault, from the last run if it is there."""
    place = WORK / f"{pixels}-{fault}-{strength:g}-{seed}"
    capture, out = place / "capture", place / "answer"
    report = out / "gap.json"
    if not report.exists():
        if not (capture / "capture.toml").exists():
            shutil.rmtree(capture, ignore_errors=True)
            faults = KINDS[pixels]
            words = {"fault": fault, "strength": strength, "seed": seed, "paths": PATHS,
                     "pixels": pixels,
                     "cfa": MOSAICS[faults.index(fault) % 4 if fault in faults else 0]}  # fmt: skip
            options = [part for name, value in words.items() for part in (f"--{name}", value)]
            _run(sys.executable, "-m", SCRIPT, capture, *options)
        _run(CAMTRUTH, "diagnose", capture, "--out", out, "--overwrite")
    found = json.loads(report.read_text(encoding="utf-8"))
    return {"fault": fault, "verdict": found["verdict"], "effects": found["effects"],
            "p_before": found["gap"]["p_value_before"], "p_after": found["gap"]["p_value_after"],
            "lead": lead(found["candidates"]), "seconds": found["seconds"]}  # fmt: skip


def lead(candidates: Sequence[Mapping[str, Any]]) -> float:
    """By what part of its score the best suspect is ahead of the next."""
    scores = sorted((one["score"] for one in candidates), reverse=True)
    return (scores[0] - scores[1]) / scores[0] if len(scores) > 1 and scores[0] > 0 else 0.0


def _run(*words: object) -> None:
    subprocess.run([*map(str, words)], check=True, stdout=subprocess.DEVNULL, cwd=HERE.parent)


def mark(answer: Mapping[str, Any]) -> str:
    """What an answer counts as; of a camera without fault, whether it is matched."""
    fault, effects = answer["fault"], answer["effects"]
    if fault == "none":
        return "right" if answer["verdict"] == "matched" else "**false alarm**"
    if not effects:
        return "not named"
    if any(e["probability"] >= 0.5 and fault not in _names(e) for e in effects):
        return "**confidently wrong**"
    if effects[0]["name"] == fault:
        return "right"
    return "in class" if fault in _names(effects[0]) else "wrong"


def _names(effect: Mapping[str, Any]) -> set[str]:
    return {effect["name"], *effect["indistinguishable_from"]}


def table(answers: Sequence[Mapping[str, Any]]) -> str:
    """One line for each fault."""
    lines = [
        "| fault | | verdict | named | ahead of the next by | p of what is left | seconds |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in answers:
        names = ", ".join(_told(effect) for effect in one["effects"]) or "–"
        ahead = f"{one['lead']:.1%}" if one["effects"] else "–"
        lines.append(
            f"| `{one['fault']}` | {mark(one)} | {one['verdict']} | {names} |"
            f" {ahead} | {one['p_after']:.2g} | {one['seconds']:.0f} |"
        )
    return "\n".join(lines) + "\n"


def _told(effect: Mapping[str, Any]) -> str:
    alike = "".join(f" or `{name}`" for name in effect["indistinguishable_from"])
    return f"`{effect['name']}`{alike} ({effect['probability']:.2f})"


def page(documents: Mapping[str, Mapping[str, Any]]) -> str:
    """The whole page.

    Args:
        documents: results by what the camera sends.
    """
    parts = [_part(HEADINGS[k], documents[k]) for k in HEADINGS if k in documents]
    return "\n".join([TEXT.read_text(encoding="utf-8").rstrip() + "\n", *parts])


def _part(heading: str, document: Mapping[str, Any]) -> str:
    answers = document["answers"]
    counts = dict.fromkeys(("right", "in class", "not named", "wrong"), 0)
    for one in answers:
        what = mark(one).strip("*")
        counts[what] = counts.get(what, 0) + 1
    told = ", ".join(f"{number} {what}" for what, number in counts.items() if number)
    return (
        f"### {heading}\n\nStrength {document['strength']:g}, seed {document['seed']}, at commit"
        f" {document['commit']}: {told} of {len(answers)}.\n\n{table(answers)}"
    )


def write_another_camera_page() -> None:
    """Write the page from the results of the last runs."""
    found = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in RESULTS.iterdir()}
    with new_file(PAGE) as scratch:
        scratch.write_text(page(found), encoding="utf-8")


def main() -> None:
    words = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    words.add_argument("--pixels", choices=tuple(KINDS), default="rgb8")
    words.add_argument("--strength", type=float, default=1.0)
    words.add_argument("--seed", type=int, default=46)
    given = words.parse_args()
    asked = functools.partial(
        answered, strength=given.strength, seed=given.seed, pixels=given.pixels
    )
    with ThreadPoolExecutor(cores()) as pool:
        answers = list(pool.map(asked, ("none", *KINDS[given.pixels])))
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"],
        cwd=HERE,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    document = {"strength": given.strength, "seed": given.seed, "commit": commit,
                "answers": answers}  # fmt: skip
    RESULTS.mkdir(parents=True, exist_ok=True)
    with new_file(RESULTS / f"{given.pixels}.json") as scratch:
        scratch.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    write_another_camera_page()


if __name__ == "__main__":
    main()
