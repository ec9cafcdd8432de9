"""`camtruth render`: light to the sensor plane, as rate images."""

from __future__ import annotations

import time
from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.argument("scene", default="chart")
@click.option("--lamp", "lamps", multiple=True, metavar="NAME", help="This lamp alone. Repeatable.")
@click.option("--together", is_flag=True, help="One more image with all the lamps at once.")
@click.option(
    "--bounces",
    type=click.IntRange(0, 16),
    default=0,
    show_default=True,
    metavar="N",
    help="Light thrown back by booth, wall and chart, so many times, and what it adds.",
)
@options.noise
@options.samples
@options.seed("Seed of the light paths.")
@options.out("render")
def command(
    scene: str,
    lamps: tuple[str, ...],
    together: bool,
    bounces: int,
    noise: float | None,
    samples: int,
    seed: int,
    out: Path,
    overwrite: bool,
) -> None:
    """Rate images of SCENE, one for each lamp.

    SCENE is a preset ('chart', 'uniform', 'edge', 'wedge') or a TOML file. Writes rate-LAMP.exr,
    photo-electrons per second at lamp level 1 with their variance, a picture rate-LAMP.png to look
    at, and shading-LAMP.svg, which says how each cause shades it along both axes.
    """
    from camtruth.rendering import render
    from camtruth.report.shading import shading_figure
    from foundation.output import new_folder
    from render.preview import write_preview
    from render.rate import write_rate
    from render.together import together as added
    from scenes.scene import load

    known = load(scene)
    for lamp in lamps:
        known.named(lamp)
    with new_folder(out, overwrite=overwrite) as folder:
        started = time.monotonic()
        images = render(
            known,
            lamps or None,
            noise=noise,
            samples=samples,
            seed=seed,
            bounces=bounces,
            watch=terminal.progress,
        )
        seconds = time.monotonic() - started
        for lamp, image in images.items():
            figure = shading_figure(known, image)
            (folder / f"shading-{lamp}.svg").write_text(figure, encoding="utf-8")
        direct = (
            render(known, lamps or None, samples=samples, seed=seed, watch=terminal.progress)
            if bounces
            else {}
        )
        if together:
            both = added(images, dict.fromkeys(images, 1.0))
            images = {**images, both.header.lamp: both}
        for lamp, image in images.items():
            write_rate(folder / f"rate-{lamp}.exr", image)
            write_preview(folder / f"rate-{lamp}.png", image)
    for lamp, image in images.items():
        worst = max(image.header.noise.values(), default=0.0)
        click.echo(
            f"{out / f'rate-{lamp}.exr'}: {image.header.samples} samples a pixel,"
            f" relative error {worst:.2g} in the noisiest panel"
        )
    for lamp in direct:
        click.echo(_what_bounces_add(lamp, bounces, direct[lamp], images[lamp]))
    click.echo(f"rendered in {seconds:.1f} s")


def _what_bounces_add(lamp: str, bounces: int, direct: object, bounced: object) -> str:
    """The least and the most that thrown back light adds to a panel, in green, with its error."""
    from render.bounced import added_light
    from render.rate import RateImage

    assert isinstance(direct, RateImage)
    assert isinstance(bounced, RateImage)
    rows = added_light(direct, bounced)
    least, most = min(rows, key=lambda row: row[1]), max(rows, key=lambda row: row[1])
    return (
        f"{lamp}: {bounces} bounce{' adds' if bounces == 1 else 's add'}"
        f" {100 * least[1]:.2f} +- {100 * least[2]:.2f} % (panel {least[0]}) to"
        f" {100 * most[1]:.2f} +- {100 * most[2]:.2f} % (panel {most[0]}) to direct light"
    )
