"""`camtruth dataset make`: a whole set of captures from one specification."""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.group()
def command() -> None:
    """Whole sets of captures, split by camera body, with every noise known."""


@command.command()
@click.argument("spec", type=options.PATH)
@options.out("dataset")
@options.resume
@options.scheduler
@options.as_json
def make(
    spec: Path,
    out: Path,
    overwrite: bool,
    resume: bool,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """The dataset that the TOML file SPEC describes.

    Every combination of cameras, bodies, lamps, levels, exposures, focus and effects. It grows in
    DIR.unfinished and moves to DIR when it is whole; a run that was stopped goes on by --resume and
    ends with the same bytes.
    """
    from camtruth.dataset import make as datasets
    from camtruth.dataset.plan import plan
    from camtruth.dataset.spec import read_spec

    planned = plan(read_spec(spec))
    with terminal.progress(f"taking {planned.frames} frames", planned.frames) as advance:
        made = datasets.make(
            out,
            planned,
            resume=resume,
            overwrite=overwrite,
            scheduler=scheduler,
            progress=advance,
        )
    if as_json:
        terminal.print_json({"format": "camtruth-dataset/1", "out": str(out), **vars(made)})
        return
    click.echo(
        f"{out}: {made.frames} frames in {made.shards} shards"
        + (f", of which {made.kept} stood there already" if made.kept else "")
    )
    click.echo(f"Check it with: camtruth verify {out}")
