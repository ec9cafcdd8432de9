"""`camtruth render`: light to the sensor plane, as rate images."""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.argument("scene", default="chart")
@click.option("--lamp", "lamps", multiple=True, metavar="NAME", help="This lamp alone. Repeatable.")
@options.noise
@options.samples
@options.seed("Seed of the light paths.")
@options.out("render")
def command(
    scene: str,
    lamps: tuple[str, ...],
    noise: float | None,
    samples: int,
    seed: int,
    out: Path,
    overwrite: bool,
) -> None:
    """Rate images of SCENE, one for each lamp.

    SCENE is a preset ('chart') or a TOML file. Writes rate-LAMP.exr, photo-electrons per second at
    lamp level 1 with their variance, and a preview rate-LAMP.png to look at.
    """
    from camtruth.preview import write_preview
    from camtruth.rendering import render
    from foundation.output import new_folder
    from render.rate import write_rate
    from scenes.scene import load

    known = load(scene)
    for lamp in lamps:
        known.named(lamp)
    with new_folder(out, overwrite=overwrite) as folder:
        images = render(
            known,
            lamps or None,
            noise=noise,
            samples=samples,
            seed=seed,
            watch=terminal.progress,
        )
        for lamp, image in images.items():
            write_rate(folder / f"rate-{lamp}.exr", image)
            write_preview(folder / f"rate-{lamp}.png", image)
    for lamp, image in images.items():
        worst = max(image.header.noise.values(), default=0.0)
        click.echo(
            f"{out / f'rate-{lamp}.exr'}: {image.header.samples} samples a pixel,"
            f" relative error {worst:.2g} in the grey panels"
        )
