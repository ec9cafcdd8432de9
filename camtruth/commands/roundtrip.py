"""`camtruth roundtrip`: the truth that went in against the estimate that comes out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from camtruth import options, terminal

if TYPE_CHECKING:
    from analysis.round_trip import Row


@click.command()
@click.option(
    "--seeds",
    type=click.IntRange(1, 1_000_000),
    default=10,
    show_default=True,
    metavar="N",
    help="How many camera bodies.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    default=("irie",),
    show_default=True,
    metavar="NAME",
    help="Estimator: a name, or FILE.py:function. Repeat to compare several on the same frames.",
)
@click.option(
    "--protocol",
    default="paper",
    show_default=True,
    metavar="NAME|FILE",
    help="Shots: a preset or a TOML file.",
)
@options.camera
@options.scene
@options.rate
@options.settings
@options.noise
@options.samples
@options.seed("Seed of the first body; the others follow.")
@options.scheduler
@options.as_json
def command(
    seeds: int,
    methods: tuple[str, ...],
    protocol: str,
    camera: str,
    scene: str,
    rates: tuple[str, ...],
    settings: tuple[str, ...],
    noise: float | None,
    samples: int,
    seed: int,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Bias and coverage of every noise parameter.

    Every seed is a new camera body; truth is the value of the population that bodies come from.
    """
    from analysis.methods import method
    from analysis.round_trip import document
    from camtruth.measuring import roundtrip
    from camtruth.rendering import render
    from camtruth.setup import prepare

    for name in methods:
        method(name)
    setup = prepare(
        camera=camera, protocol_name=protocol, scene=scene, rates=rates, settings=settings
    )
    rendered = render(
        setup.scene, setup.missing, noise=noise, samples=samples, seed=seed, watch=terminal.progress
    )
    images = {**rendered, **setup.images}
    with terminal.progress(f"round trips of {seeds} bodies", seeds) as advance:
        rows = roundtrip(
            setup.camera,
            setup.protocol,
            images,
            seeds=range(seed, seed + seeds),
            methods=methods,
            scheduler=scheduler,
            progress=advance,
        )
    if as_json:
        terminal.print_json(document(rows, seeds))
    else:
        terminal.print_table(HEADS, [_cells(row) for row in rows])


HEADS = ("parameter", "", "method", "truth", "estimate", "bias", "rms", "coverage", "unit")


def _cells(row: Row) -> tuple[str, ...]:
    return (
        row.parameter,
        row.channel,
        row.method,
        terminal.figure(row.truth),
        terminal.rounded(row.estimate, row.bias_se),
        terminal.with_error(row.bias, row.bias_se),
        terminal.rounded(row.rms, row.bias_se),
        "–" if row.coverage is None else f"{row.coverage:.0%}",
        row.unit,
    )
