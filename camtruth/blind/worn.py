"""An effect from elsewhere in one of our cameras: its function between two of our effects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camtruth.blind.foreign.outsider import About, Outsider
from sensor.camera import Camera
from sensor.effect import Effect, Stage
from sensor.effects.demosaic import Demosaic
from sensor.signal import Quantity, Signal
from sensor.stream import Stream

QUANTITIES = {
    "rate": Quantity.RATE,
    "electrons": Quantity.ELECTRONS,
    "mosaic": Quantity.DN,
    "demosaic": Quantity.DN,
    "image": Quantity.DN,
    "codes": Quantity.CODE,
}
STAGES = {"mosaic": Stage.PROCESSING}
"""What is given the mosaic stands right before the demosaicer, whatever its physics is called."""


def wear(camera: Camera, outsider: Outsider, strength: float) -> Camera:
    """The camera with an effect from elsewhere; a demosaicer takes the place of the camera's."""
    if outsider.place == "demosaic":
        camera = camera.without(Demosaic)
    return camera.plus(worn(outsider, strength))


def fits(camera: Camera, outsider: Outsider) -> bool:
    """Whether the camera has what the effect acts on."""
    coloured = camera.get(Demosaic) is not None
    wants_colours = outsider.place in ("demosaic", "image") or outsider.source in (
        "libjpeg",
        "ffmpeg",
        "opencv",
    )
    return coloured or not wants_colours


def worn(outsider: Outsider, strength: float) -> Effect:
    """The effect as our cameras know effects: a kind of its own."""

    @dataclass(frozen=True, kw_only=True)
    class Worn(Effect):
        name = f"outsider {outsider.name}"
        stage = STAGES.get(outsider.place, Stage(outsider.stage))
        position = Demosaic.position if outsider.place == "demosaic" else outsider.order
        reference = outsider.source
        quantity_override = QUANTITIES[outsider.place]

        def apply(self, signal: Signal, stream: Stream) -> Signal:
            told = about(signal, stream)
            changed = outsider.act(np.array(signal.numpy()), strength, told)
            return signal.from_numpy(np.ascontiguousarray(changed, dtype=np.float32))

    return Worn()


def about(signal: Signal, stream: Stream) -> About:
    """What a function from elsewhere may know."""
    shot, form = signal.shot, signal.format
    return About(
        shot=shot.label,
        lamps=() if shot.dark else shot.light,
        exposure_s=shot.exposure_s,
        frames=tuple(signal.frames),
        cfa=form.cfa,
        bits=form.bits,
        black_dn=form.black_dn,
        seed=stream.seed,
        body_seed=stream.body_seed,
    )
