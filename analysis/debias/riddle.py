"""Red and blue read noise of 1.6 and 1.2 DN against green's 0.6, shot noise the other way round.

On grey, where all colours end at one level, two things may have been done to a colour of one sensor
after its noise was made: a gain w, and mixing or smoothing that leaves a^2 of every variance. Then

    read^2 = a^2 w^2 r^2,    k^2 = a^2 w g,    so    read^2 / k^2 = w r^2 / g,

whatever a is: white balance shows in the ratio, a colour matrix, YUV, a demosaic or any other
linear filter does not. Each is tried here on a camera whose colours are alike, by photon transfer,
which has no table of attenuation to be wrong.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from analysis.bias.setting import light
from analysis.estimators.photon_transfer import photon_transfer
from analysis.parameters import Estimate
from scenes.geometry import analysis_panels
from scenes.scene import load as load_scene
from sensor.camera import Camera
from sensor.camera_file import load, with_setting
from sensor.colours import CHANNELS, Colours
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import load as load_protocol
from sensor.record import record

GAIN, READ_DN, BLACK_DN = 0.1, 1.5, 12.0

ANSWERS: Mapping[str, Sequence[str]] = {
    "nothing": (),
    "white balance, red 2.6 and blue 2.0": (
        "white_balance.red_gain=2.6",
        "white_balance.blue_gain=2.0",
    ),
    "colour matrix, saturation 1.3": ("color_matrix.saturation=1.3",),
    "YUV 4:2:2 in 8 bits": ("chroma_subsampling.mode=1",),
    "YUV 4:1:1 in 8 bits": ("chroma_subsampling.mode=2",),
    "white balance, then YUV 4:1:1": (
        "white_balance.red_gain=2.6",
        "white_balance.blue_gain=2.0",
        "chroma_subsampling.mode=2",
    ),
}
"""What may have been done to the colours, as settings of effects."""


def alike() -> Camera:
    """The i400 with one gain and one read noise in all colours, far above 0."""
    made = load("i400")
    share = {c: made.gain_dn_per_e[c] * made.sensitivity[c] / GAIN for c in CHANNELS}
    made = dataclasses.replace(
        made,
        gain_dn_per_e=Colours.of(GAIN),
        sensitivity=Colours(**share),
        black_dn=BLACK_DN,
    )
    for setting in (f"read_noise.thermal_dn={READ_DN}", "fpn.sigma_dn=0.3", "prnu.ratio=0.01"):
        made = with_setting(made, setting)
    return made


def ratios(settings: Sequence[str], seed: int = 1) -> dict[str, Any]:
    """Read noise, shot coefficient, and read^2 / k^2 as the frames show them, by channel."""
    camera = alike()
    for setting in settings:
        camera = with_setting(camera, setting)
    panels = analysis_panels(load_scene("chart"))
    # Level 0.4: with the gains of white balance red still ends below 255 DN.
    rates = {lamp: np.float32(0.4) * rate for lamp, rate in light().items()}
    small, cut, moved = panels_only(camera, rates, panels)
    found = photon_transfer(
        record(small.with_body(seed), load_protocol("paper"), cut, seed=seed, panels=moved)
    )
    result: dict[str, Any] = {}
    for channel in CHANNELS:
        read, k = (found.channels[channel][key] for key in ("read", "shot_coefficient"))
        assert isinstance(read, Estimate)
        assert isinstance(k, Estimate)
        result[channel] = {
            "read": read.value,
            "shot_coefficient": k.value,
            "ratio": (read.value / k.value) ** 2,
        }
    return result
