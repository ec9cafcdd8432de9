"""`camtruth diagnose`: where a simulated camera differs from a real one, and why."""

from __future__ import annotations

import json
from pathlib import Path

import click

from camtruth import options, terminal

STEPS = 70
"""Suspects, the ones among them that are followed, and what comes before and after."""


@click.command()
@click.argument("capture", type=options.PATH)
@click.option(
    "--model",
    metavar="NAME|FILE",
    help="Camera to start from; its effects beyond the base count as known.",
)
@click.option(
    "--without",
    multiple=True,
    metavar="EFFECT",
    help="Do not suspect this effect. Repeat for several.",
)
@click.option(
    "--effects",
    "files",
    multiple=True,
    type=options.PATH,
    metavar="FILE.py",
    help="Suspect the effects of your own file as well. Repeat for several.",
)
@options.out("diagnose")
@options.as_json
def command(
    capture: Path,
    model: str | None,
    without: tuple[str, ...],
    files: tuple[Path, ...],
    out: Path,
    overwrite: bool,
    as_json: bool,
) -> None:
    """The sim-to-real gap of the frames in CAPTURE.

    Calibrates the paper's camera to the frames, measures where they still differ, holds every
    effect of the catalogue against the difference, and names one only where frames that took no
    part in the search bear it out. Writes gap.json, gap.html and camera.toml, the camera with what
    was found. The truth beside the frames is never read.
    """
    from camtruth.diagnosing import diagnosis
    from camtruth.report.gap import answer, page
    from foundation.output import new_folder
    from foundation.users_code import effects_of_users
    from sensor.camera_file import write
    from sensor.catalogue import effects_from_file

    more = [kind for file in files for kind in effects_from_file(file)]
    with new_folder(out, overwrite=overwrite) as folder:
        with terminal.telling("diagnosing", STEPS) as say, effects_of_users(files):
            found = diagnosis(capture, model, without=without, more=more, watch=say)
        document = found.report.to_json()
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
        (folder / "gap.json").write_text(text, encoding="utf-8")
        line = f"camtruth diagnose {capture}"
        (folder / "gap.html").write_text(page(found, line), encoding="utf-8")
        if found.camera is not None:
            write(folder / "camera.toml", found.camera)
    if as_json:
        terminal.print_json(document)
    else:
        click.echo(answer(found.report))
        click.echo(f"{out / 'gap.html'} shows it.")
