"""`camtruth capture`: rate images through a camera, to frames with their truth."""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.argument("protocol", default="paper")
@options.camera
@options.scene
@options.rate
@options.settings
@options.noise
@options.samples
@options.seed("Seed of everything that is drawn anew in every frame, and of the light paths.")
@options.body_seed
@options.out("capture")
def command(
    protocol: str,
    camera: str,
    scene: str,
    rates: tuple[str, ...],
    settings: tuple[str, ...],
    noise: float | None,
    samples: int,
    seed: int,
    body_seed: int,
    out: Path,
    overwrite: bool,
) -> None:
    """Frames of PROTOCOL, with the truth beside them.

    PROTOCOL is a preset ('paper') or a TOML file. Writes capture.toml, a stack of frames for each
    shot, rate-LAMP.exr for each lamp, and truth.json, which no estimator reads.
    """
    from camtruth.rendering import render
    from camtruth.setup import prepare
    from camtruth.simulating import capture_to, grey_panels
    from foundation.output import new_folder

    setup = prepare(
        camera=camera,
        protocol_name=protocol,
        scene=scene,
        rates=rates,
        settings=settings,
        body_seed=body_seed,
    )
    frames = sum(shot.frames for shot in setup.protocol.shot)
    with new_folder(out, overwrite=overwrite) as folder:
        rendered = render(
            setup.scene,
            setup.missing,
            noise=noise,
            samples=samples,
            seed=seed,
            watch=terminal.progress,
        )
        images = {**rendered, **setup.images}
        with terminal.progress(f"taking {frames} frames", frames) as advance:
            capture_to(
                folder,
                setup.camera,
                setup.protocol,
                images,
                seed=seed,
                panels=grey_panels(images) or setup.panels_without_light(),
                scene=setup.scene_name,
                progress=advance,
            )
    click.echo(f"{out}: {frames} frames in {len(setup.protocol.shot)} shots by '{camera}'")
    click.echo(f"Next: camtruth measure {out}")
