"""Captures from rate images: in memory, or to a folder with the truth beside the frames."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from foundation.panel import Panel
from render.rate import RateImage, write_rate
from scenes.geometry import GREY_ROW
from sensor.camera import Camera
from sensor.capture_folder import TRUTH, write_capture
from sensor.frames import PANEL_PX, Capture
from sensor.protocol import Protocol
from sensor.record import record
from sensor.truth import truth


def rates_of(images: Mapping[str, RateImage]) -> dict[str, NDArray[np.float32]]:
    """The rates alone, by lamp."""
    return {lamp: image.rate_e_per_s for lamp, image in images.items()}


def grey_panels(images: Mapping[str, RateImage]) -> tuple[Panel, ...]:
    """The areas to analyse: 50 x 50 pixels in the middle of each grey panel that is in the image.

    Of a chart that shows no grey panel all panels; without an image none.
    """
    if not images:
        return ()
    known = {panel.name: panel for panel in next(iter(images.values())).header.panels}
    chosen = [known[name] for name in GREY_ROW if name in known] or list(known.values())
    return tuple(_middle(panel) for panel in chosen)


def _middle(panel: Panel) -> Panel:
    w, h = min(panel.w, PANEL_PX), min(panel.h, PANEL_PX)
    x, y = panel.x + (panel.w - w) // 2, panel.y + (panel.h - h) // 2
    return Panel(name=panel.name, x=x, y=y, w=w, h=h)


def capture(
    camera: Camera,
    protocol: Protocol,
    images: Mapping[str, RateImage],
    *,
    seed: int = 0,
    panels: Sequence[Panel] | None = None,
) -> Capture:
    """Take the shots of a protocol with a camera, frames in memory.

    Args:
        camera: the camera.
        protocol: the shots.
        images: a rate image for every lamp of the protocol.
        seed: seed of what is not fixed in the camera body.
        panels: areas to analyse; the middle of the grey panels by default.
    """
    panels = grey_panels(images) if panels is None else panels
    return record(camera, protocol, rates_of(images), seed=seed, panels=panels)


def capture_to(
    folder: Path,
    camera: Camera,
    protocol: Protocol,
    images: Mapping[str, RateImage],
    *,
    seed: int = 0,
    panels: Sequence[Panel] = (),
    scene: str | None = None,
    progress: Callable[[int], None] = lambda frames: None,
) -> None:
    """Take the shots of a protocol into a folder, with rate images and truth record.

    Args:
        folder: an empty folder; see `foundation.output.new_folder`.
        camera: the camera.
        protocol: the shots.
        images: a rate image for every lamp of the protocol.
        seed: seed of what is not fixed in the camera body.
        panels: areas to analyse.
        scene: name of the scene.
        progress: told the number of frames just finished.
    """
    names = {lamp: f"rate-{lamp}.exr" for lamp in images}
    for lamp, image in images.items():
        write_rate(folder / names[lamp], image)
    write_capture(
        folder,
        camera,
        protocol,
        rates_of(images),
        seed=seed,
        scene=scene,
        panels=panels,
        rate_files=names,
        progress=progress,
    )
    known = {lamp: dataclasses.asdict(image.header) for lamp, image in images.items()}
    document = truth(camera, protocol, seed, light=known)
    text = json.dumps(document, indent=1, allow_nan=False)
    (folder / TRUTH).write_text(text + "\n", encoding="utf-8")
