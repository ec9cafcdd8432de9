"""What is known of every pixel: the light that fell on it, and its own response and offset.

The maps are made by the effects themselves from the seeds of the truth record: the response by
letting one electron into every photosite, the offset by letting in none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.source import Source
from foundation.backend import backend
from foundation.errors import InputError
from sensor.camera import GREY, PRISM, Camera
from sensor.catalogue import effect
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.frames import Frames
from sensor.prism import sensors
from sensor.protocol import Shot
from sensor.signal import Quantity, Signal
from sensor.simulation import stream_of

FOLDER = "truth"

RESPONSES = {"prnu": "1", "large_scale_prnu": "1"}
OFFSETS = {"fpn": "e-", "column_fpn": "e-"}
"""Effects whose pattern is the same in every frame and shot, with the unit of their map."""


@dataclass(frozen=True, kw_only=True)
class Map:
    """A map over the pixels, (H, W) float32, or (H, W, 3) where a pixel has three colours."""

    file: str
    what: str
    unit: str
    values: NDArray[np.float32]

    def write(self, folder: Path) -> None:
        """Write it below a folder."""
        path = folder / self.file
        path.parent.mkdir(exist_ok=True)
        np.save(path, self.values, allow_pickle=False)


def light_maps(source: Source) -> Iterator[Map]:
    """Mean photo-electrons of every pixel, shot by shot, where the light is known."""
    for frames in source.capture.frames:
        electrons = source.electrons(frames.shot)
        if electrons is None or frames.shot.dark:
            continue
        yield Map(
            file=f"{FOLDER}/electrons-{frames.shot.label}.npy",
            what=f"mean photo-electrons of a pixel in a frame of shot '{frames.shot.label}'",
            unit="e-",
            values=_seen(electrons, frames),
        )


def _seen(electrons: NDArray[np.float32], frames: Frames) -> NDArray[np.float32]:
    """What the photosites see: all three colours of demosaiced frames, else their own."""
    if frames.demosaiced:
        return electrons
    if frames.cfa is None:
        return electrons[..., 1]
    seen = np.empty(electrons.shape[:2], dtype=np.float32)
    for k, colour in enumerate(frames.cfa):
        i, j = k // 2, k % 2
        seen[i::2, j::2] = electrons[i::2, j::2, "RGB".index(colour)]
    return seen


def pattern_maps(source: Source) -> Iterator[Map]:
    """Response and offset of every photosite of this camera body, one map an effect.

    None where they were drawn by another kind of backend than is at work here: its generator
    differs, and so would the pattern.
    """
    truth = source.truth
    if truth is None or (truth.get("backend") == "scalar") != (not backend().jit):
        return
    camera = _camera(source, truth)
    for known in camera.effects:
        if known.name in RESPONSES:
            yield Map(
                file=f"{FOLDER}/response-{known.name}.npy",
                what=f"response of each photosite by '{known.name}', relative to its mean",
                unit=RESPONSES[known.name],
                values=_applied(camera, known, 1.0),
            )
        if known.name in OFFSETS:
            yield Map(
                file=f"{FOLDER}/offset-{known.name}.npy",
                what=f"offset of each photosite by '{known.name}', the same in every frame",
                unit=OFFSETS[known.name],
                values=_applied(camera, known, 0.0),
            )


def _camera(source: Source, truth: Mapping[str, Any]) -> Camera:
    """The body as far as its patterns go: format, seed, and the effects that make them."""
    frames = source.capture.frames[0]
    gain = truth["gain_dn_per_e"]
    effects = [
        effect(entry["name"]).with_parameters(
            {name: each["value"] for name, each in entry["parameters"].items()}
        )
        for entry in truth["effects"]
        if entry["name"] in RESPONSES or entry["name"] in OFFSETS
    ]
    return Camera(
        name=source.document.camera,
        width=frames.width,
        height=frames.height,
        pixels=frames.pixels,
        bits=frames.bits,
        cfa=frames.cfa or (PRISM if frames.demosaiced else GREY),
        gain_dn_per_e=Colours(**gain) if isinstance(gain, Mapping) else Colours.of(gain),
        effects=tuple(effects),
        body_seed=truth["body_seed"],
    )


def _applied(camera: Camera, known: Effect, electrons: float) -> NDArray[np.float32]:
    """What an effect makes of so many electrons everywhere: (H, W), of three sensors (H, W, 3)."""
    if camera.cfa == PRISM:
        each = [_applied(one, known, electrons) for one in sensors(camera).values()]
        return np.stack(each, axis=-1)
    where = backend()
    shot = Shot(label="map", exposure_s=0.0, frames=1)
    frames = range(1)
    signal = Signal(
        numbers=where.tensor(np.full((1, camera.height, camera.width), electrons)),
        quantity=Quantity.ELECTRONS,
        format=camera.format,
        shot=shot,
        frames=frames,
        backend=where,
    )
    after = known.apply(signal, stream_of(camera, known, shot, 0, frames, where))
    values = np.asarray(after.value.numpy(), dtype=np.float32)
    return values.reshape(camera.height, camera.width)


def truth_maps(source: Source) -> Iterator[Map]:
    """All that is known of every pixel.

    Raises:
        InputError: when the truth record names what no effect is.
    """
    yield from light_maps(source)
    try:
        yield from pattern_maps(source)
    except (KeyError, TypeError) as problem:
        raise InputError(
            f"{source.folder / 'truth.json'} is no whole truth record ({problem})",
            "expected the keys of camtruth-truth/1",
            "make the capture anew, or remove the file to export frames alone",
        ) from None
