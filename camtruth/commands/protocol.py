"""`camtruth protocol`: what to capture."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from camtruth import options, terminal

if TYPE_CHECKING:
    from analysis.identifiability.recommend import Recommendation, Step

STEPS = 50
"""Effects, and what comes before and after."""

PATHS = 16
"""Light paths per pixel: what they leave is the same in all shots, and far below the noise."""

SMALLEST_PX, LARGEST_PX = 64, 640

FORMAT = "camtruth-recommendation/1"


@click.group()
def command() -> None:
    """What to capture, before it is captured."""


@command.command()
@options.camera
@click.option(
    "--scene",
    default="chart",
    show_default=True,
    metavar="NAME|FILE",
    help="What is photographed: a preset or a TOML file.",
)
@click.option(
    "--size",
    default="160x120",
    show_default=True,
    metavar="WxH",
    help="Pixels of the small frames that are simulated.",
)
@click.option(
    "--strength",
    type=options.Between(1e-4, 10),
    default=0.1,
    show_default=True,
    metavar="PART",
    help="Strength of the effects that are to be told apart, of their defaults.",
)
@click.option(
    "--frames", type=click.IntRange(1), metavar="N", help="At most so many frames in all shots."
)
@click.option("--out", type=options.PATH, metavar="FILE", help="Write the protocol here.")
@click.option("--overwrite", is_flag=True, help="Replace the file if it is there.")
@options.as_json
def recommend(
    camera: str,
    scene: str,
    size: str,
    strength: float,
    frames: int | None,
    out: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """The shots that separate most effects of the catalogue for the fewest frames.

    Every effect is simulated under every shot that one might take. Shots are chosen in which the
    effects look least alike once the camera is calibrated. Prints a protocol for
    'camtruth capture', with what it cannot separate; the light 'uniform' is an even field, whose
    rate image is given as --rate uniform=FILE.
    """
    from analysis.identifiability.known import small_light
    from analysis.identifiability.recommend import recommend as recommended
    from foundation.errors import OutputError
    from foundation.output import new_file
    from sensor.camera_file import load

    if out is not None and out.exists() and not overwrite:
        raise OutputError(
            f"{out} is there already",
            "expected a new file",
            "choose another with --out, or pass --overwrite",
        )
    known = load(camera)
    width, height = pixels(size)
    with terminal.telling("recommending", STEPS) as say:
        say("light")
        light = small_light(scene, width, height, PATHS)
        found = recommended(known, light, strength=strength, most_frames=frames, watch=say)
    text = toml(found, known.name, scene, strength)
    if out is not None:
        with new_file(out) as scratch:
            scratch.write_text(text, encoding="utf-8")
    if as_json:
        terminal.print_json(document(found, scene, strength))
    else:
        click.echo(text if out is None else f"{summary(found)}\n{out}", nl=out is not None)


def pixels(size: str) -> tuple[int, int]:
    """Width and height from their spelling.

    Raises:
        InputError: for anything else.
    """
    from foundation.errors import InputError

    width, _, height = size.partition("x")
    sides = [int(side) if side.isdecimal() else 0 for side in (width, height)]
    if min(sides) < SMALLEST_PX or max(sides) > LARGEST_PX or any(side % 2 for side in sides):
        raise InputError(
            f"size '{size}'",
            f"expected WIDTHxHEIGHT, even numbers from {SMALLEST_PX} to {LARGEST_PX}",
            "write it as in 160x120",
        )
    return sides[0], sides[1]


def summary(found: Recommendation) -> str:
    """What the protocol is worth, in one sentence."""
    best = found.front[-1]
    words = (
        f"{best.separated} of {len(found.told.names)} effects are separated with {best.total}"
        f" frames in {len(best.shots)} shots"
    )
    if found.reference is not None:
        words += f"; the shots of the paper separate {found.reference.separated}"
    return f"{words}."


def toml(found: Recommendation, camera: str, scene: str, strength: float) -> str:
    """The protocol as a file, with what it tells as its head."""
    import tomli_w

    lines = [
        f"For {camera} and scene {scene}, effects at {strength:g} of their defaults.",
        summary(found),
    ]
    lines += [f"Confused: {', '.join(group)}." for group in found.told.classes]
    if found.told.unseen:
        lines.append(f"Not seen: {', '.join(found.told.unseen)}.")
    head = "".join(f"# {line}\n" for line in lines)
    return head + tomli_w.dumps(plain(found))


def plain(found: Recommendation) -> dict[str, Any]:
    """The protocol as TOML spells it."""
    shots = []
    for shot in found.protocol.shot:
        entry = {k: v for k, v in dataclasses.asdict(shot).items() if v is not None}
        shots.append(entry | {"light": shot.light[0], "level": shot.level[0]})
    return {"name": found.protocol.name, "shot": shots}


def document(found: Recommendation, scene: str, strength: float) -> dict[str, Any]:
    """The protocol and what it tells, as data."""

    def step(one: Step) -> dict[str, Any]:
        return {"shots": list(one.shots), "frames": one.total, "separated": one.separated}

    return {
        "format": FORMAT,
        "scene": scene,
        "strength": strength,
        "protocol": plain(found),
        "frames": found.front[-1].total,
        "effects": len(found.told.names),
        "separated": list(found.told.separated),
        "confused": found.told.classes,
        "unseen": list(found.told.unseen),
        "front": [step(one) for one in found.front],
        "paper": step(found.reference) if found.reference is not None else None,
    }
