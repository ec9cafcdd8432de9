"""`camtruth reproduce`: the paper's figures and tables beside ours."""

from __future__ import annotations

import json
from pathlib import Path

import click

from camtruth import options, terminal

SEEDS = 8
"""Bodies: a standard error of a third of a percent of most figures."""


@click.command()
@click.option(
    "--seeds",
    type=click.IntRange(2, 1_000_000),
    default=SEEDS,
    show_default=True,
    metavar="N",
    help="How many camera bodies.",
)
@options.camera
@options.scene
@options.rate
@options.samples
@options.seed("Seed of the first body and of the light paths; the other bodies follow.")
@options.out("reproduce")
@options.as_json
def command(
    seeds: int,
    camera: str,
    scene: str,
    rates: tuple[str, ...],
    samples: int,
    seed: int,
    out: Path,
    overwrite: bool,
    as_json: bool,
) -> None:
    """The paper's figures, equations and tables, made again from simulated frames.

    Writes reproduce.html and reproduce.json: every printed figure beside ours with its standard
    error, and why where they differ.
    """
    from analysis.reproduce.reproduction import reproduce
    from camtruth.rendering import render
    from camtruth.report.reproduction import page
    from camtruth.setup import prepare
    from camtruth.simulating import grey_panels, rates_of
    from foundation.output import new_folder, refuse_taken

    setup = prepare(camera=camera, protocol_name="paper", scene=scene, rates=rates)
    refuse_taken(out, overwrite=overwrite)
    rendered = render(
        setup.scene, setup.missing, samples=samples, seed=seed, watch=terminal.progress
    )
    images = {**rendered, **setup.images}
    with terminal.progress(f"the technique on {seeds} bodies", seeds) as advance:
        made = reproduce(
            setup.camera,
            setup.protocol,
            rates_of(images),
            grey_panels(images),
            seeds=range(seed, seed + seeds),
            progress=advance,
        )
    document = made.to_json()
    words = (
        f"camtruth reproduce --camera {camera} --scene {scene} --seeds {seeds}"
        f" --samples {samples} --seed {seed}"
    )
    with new_folder(out, overwrite=overwrite) as folder:
        (folder / "reproduce.html").write_text(page(made, words), encoding="utf-8")
        text = json.dumps(document, indent=1, allow_nan=False)
        (folder / "reproduce.json").write_text(text + "\n", encoding="utf-8")
    if as_json:
        terminal.print_json(document)
    else:
        click.echo(f"{out / 'reproduce.html'}")
