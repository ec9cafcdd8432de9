"""`camtruth export`: a capture in another program's format, with its truth beside it."""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.argument("capture", type=options.PATH)
@click.option(
    "--format",
    "format_name",
    required=True,
    metavar="NAME",
    help="png, tiff, tiff-pages, dng, fits, npy, zarr, ffv1, emva1288 or exr.",
)
@click.option(
    "--licence",
    "--license",
    metavar="SPDX",
    help="Licence of the frames; CC0-1.0 for simulated ones, to be told for real ones.",
)
@options.out("export")
@options.resume
@options.as_json
def command(
    capture: Path,
    format_name: str,
    licence: str | None,
    out: Path,
    overwrite: bool,
    resume: bool,
    as_json: bool,
) -> None:
    """CAPTURE in the format of another program.

    With frames.csv, truth.json, the rate images, maps of what is known of every pixel, a licence,
    a dataset card (Croissant) and checksums: a reader needs nothing of camtruth. It grows in
    DIR.unfinished and moves to DIR when it is whole; a run that was stopped goes on by --resume.
    """
    from camtruth.exchange import export as exchange
    from foundation.output import refuse_taken
    from foundation.resumable import resumable_folder

    refuse_taken(out, overwrite=overwrite)
    source, chosen, named = exchange.prepare(capture, format_name, licence)
    frames = sum(stack.count for stack in source.capture.frames)
    with (
        resumable_folder(
            out,
            exchange.asked(source, chosen, named),
            resume=resume,
            overwrite=overwrite,
            keep_refused=False,
        ) as folder,
        terminal.progress(f"writing {chosen.name}", frames) as advance,
    ):
        made = exchange.export(folder, source, chosen, named, progress=advance)
    if as_json:
        terminal.print_json(
            {
                "format": "camtruth-export/1",
                "out": str(out),
                "frames_as": chosen.name,
                "frames": made.frames,
                "files": made.files,
                "kept": made.kept,
                "maps": list(made.maps),
                "licence": named,
            }
        )
        return
    click.echo(
        f"{out}: {made.frames} frames in {made.files} files, {chosen.says}"
        + (f"; {made.kept} files stood there already" if made.kept else "")
    )
    click.echo(f"Check it with: camtruth verify {out}")
