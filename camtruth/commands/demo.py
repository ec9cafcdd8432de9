"""`camtruth demo`: the whole way from a scene to a page with estimates beside the truth."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from camtruth import options, terminal

SAMPLES = 72
"""Light paths per pixel: they leave a thirtieth of the smallest PRNU that the paper prints, and
rendering stays within a minute or two without LLVM."""

SEEDS = 8
"""Bodies of the round trip: enough for a standard error, few enough for a minute."""


@click.command()
@options.camera
@options.scene
@click.option("--protocol", default="paper", show_default=True, metavar="NAME|FILE", help="Shots.")
@click.option(
    "--samples",
    type=click.IntRange(1, 1_000_000),
    default=SAMPLES,
    show_default=True,
    metavar="N",
    help="Light paths per pixel.",
)
@click.option(
    "--seeds",
    type=click.IntRange(1, 1_000_000),
    default=SEEDS,
    show_default=True,
    metavar="N",
    help="Camera bodies of the round trip.",
)
@options.seed("Seed of the frames and of the light paths.")
@options.body_seed
@options.out("demo")
def command(
    camera: str,
    scene: str,
    protocol: str,
    samples: int,
    seeds: int,
    seed: int,
    body_seed: int,
    out: Path,
    overwrite: bool,
) -> None:
    """The main job on its defaults, to one page.

    Renders a ColorChecker under both lamps, takes the paper's protocol with a simulated camera,
    measures the frames, compares with the truth, and writes report.html beside the capture.
    """
    from analysis.round_trip import document
    from camtruth.measuring import measure, roundtrip
    from camtruth.rendering import render
    from camtruth.report.page import Contents, page
    from camtruth.setup import prepare
    from camtruth.simulating import capture_to, grey_panels
    from foundation.output import new_folder, write_checksums
    from sensor.capture_folder import TRUTH, read_capture

    seconds: dict[str, float] = {}

    @contextmanager
    def timed(part: str) -> Iterator[None]:
        started = time.monotonic()
        yield
        seconds[part] = time.monotonic() - started

    setup = prepare(camera=camera, protocol_name=protocol, scene=scene, body_seed=body_seed)
    frames = sum(shot.frames for shot in setup.protocol.shot)
    with new_folder(out, overwrite=overwrite) as folder:
        with timed("rendering"):
            images = render(
                setup.scene, setup.missing, samples=samples, seed=seed, watch=terminal.progress
            )
        panels = grey_panels(images) or setup.panels_without_light()
        taken = folder / "capture"
        taken.mkdir()
        with timed("frames"), terminal.progress(f"taking {frames} frames", frames) as advance:
            capture_to(
                taken,
                setup.camera,
                setup.protocol,
                images,
                seed=seed,
                panels=panels,
                scene=setup.scene_name,
                progress=advance,
            )
            write_checksums(taken)
        with timed("measuring"), terminal.progress("measuring"):
            found = measure(taken)
        with timed("round trips"), terminal.progress(f"round trips of {seeds} bodies", seeds) as go:
            rows = roundtrip(
                setup.camera,
                setup.protocol,
                images,
                seeds=range(body_seed, body_seed + seeds),
                panels=panels,
                progress=go,
            )
        contents = Contents(
            command=_again(click.get_current_context()),
            camera=setup.camera,
            protocol=setup.protocol,
            images=images,
            capture=read_capture(taken),
            found=found,
            truth=json.loads((taken / TRUTH).read_text(encoding="utf-8")),
            rows=rows,
            seeds=seeds,
            seconds=seconds,
        )
        with terminal.progress("writing the report"):
            (folder / "report.html").write_text(page(contents), encoding="utf-8")
        for name, answer in (("noise", found.to_json()), ("roundtrip", document(rows, seeds))):
            text = json.dumps(answer, indent=1, allow_nan=False)
            (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    click.echo(f"{out / 'report.html'}")


def _again(ctx: click.Context) -> str:
    """The command line that makes the same figures, whatever the defaults will be then."""
    words = ["camtruth demo"]
    for name in ("camera", "scene", "protocol", "samples", "seeds", "seed", "body_seed"):
        words.append(f"--{name.replace('_', '-')} {ctx.params[name]}")
    return " ".join(words)
