"""`camtruth import`: frames of other programs and real cameras to a capture folder."""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.argument("folder", type=options.PATH)
@click.option(
    "--shots",
    type=options.PATH,
    metavar="FILE",
    help="The shots as in capture.toml; FOLDER's own shots.toml or capture.toml by default.",
)
@click.option(
    "--exposure",
    "exposures",
    multiple=True,
    metavar="LABEL=SECONDS",
    help="Exposure of a shot whose files do not state it; *=SECONDS for all such.",
)
@click.option(
    "--light",
    "lights",
    multiple=True,
    metavar="LABEL=LAMP[@LEVEL]",
    help="Lamps of a shot, 'none' in the dark; *=LAMP for all others.",
)
@click.option("--camera", metavar="TEXT", help="What to call the camera, where no header does.")
@click.option("--bits", type=click.IntRange(1, 16), metavar="N", help="Significant bits.")
@click.option(
    "--cfa",
    type=click.Choice(["RGGB", "BGGR", "GRBG", "GBRG", "none"]),
    help="Colours of the mosaic from its top left, or none for a grey camera.",
)
@click.option(
    "--shift",
    type=click.IntRange(0, 15),
    metavar="N",
    help="Shift samples to the right by N bits that are 0 in all of them.",
)
@click.option(
    "--panels",
    type=click.Choice(["chart", "none"]),
    default="none",
    show_default=True,
    help="Find the panels of a colour chart; look at panels.png.",
)
@click.option(
    "--panel",
    "given",
    multiple=True,
    metavar="NAME=X,Y,W,H",
    help="An area to analyse, in pixels. Repeat for several.",
)
@options.out("import")
@options.resume
@options.as_json
def command(
    folder: Path,
    shots: Path | None,
    exposures: tuple[str, ...],
    lights: tuple[str, ...],
    camera: str | None,
    bits: int | None,
    cfa: str | None,
    shift: int | None,
    panels: str,
    given: tuple[str, ...],
    out: Path,
    overwrite: bool,
    resume: bool,
    as_json: bool,
) -> None:
    """The frames in FOLDER as a capture folder.

    PNG, TIFF, DNG and camera raw, FITS, video, NPY, Zarr. A folder of single images is a shot; so
    is a file of several frames. Exposures come from EXIF or FITS headers; what no header states is
    asked for, never guessed. import.json records where every figure came from. A run that was
    stopped goes on by --resume, and reads only the shots that are missing.
    """
    from camtruth.exchange import answers, bringing_in
    from camtruth.exchange import panels as charts
    from foundation.output import refuse_taken
    from foundation.resumable import resumable_folder

    refuse_taken(out, overwrite=overwrite)
    said = answers.Answers(
        exposure_s=answers.parse_exposures(exposures),
        light=answers.parse_lights(lights),
        camera=camera,
        bits=bits,
        cfa=cfa,
        shift=shift,
    )
    areas = charts.parse(given)
    found = bringing_in.look(folder, shots)
    said = bringing_in.with_manifest(said, found.manifest)
    answers.settle(found.reels, said)
    answers.camera_of(found.reels, said)
    asked = bringing_in.asked(folder, found, said, panels, areas)
    with (
        resumable_folder(
            out, asked, resume=resume, overwrite=overwrite, keep_refused=False
        ) as scratch,
        terminal.progress("reading") as advance,
    ):
        made = bringing_in.bring_in(
            scratch, folder, found, said, panels=panels, given=areas, progress=advance
        )
    for note in made.notes:
        click.echo(f"Note: {note}.", err=True)
    if as_json:
        terminal.print_json(
            {"format": "camtruth-import/1", "out": str(out), **vars(made), "notes": [*made.notes]}
        )
        return
    click.echo(
        f"{out}: {made.frames} frames in {made.shots} shots, {made.pixels}, {made.bits} bits,"
        f" {made.panels} panels"
    )
    click.echo(f"Next: camtruth measure {out}")
