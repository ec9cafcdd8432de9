"""The truth record: what went into simulated frames, in the terms that estimators answer in.

Noise figures come in two kinds. The population value is that of the distribution the camera body
was drawn from; the realised one is that of this very body's pattern. For noise that is drawn anew
in every frame the two are the same.
"""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foundation.backend import Backend, backend
from sensor.camera import PRISM, Camera
from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect
from sensor.effects.dark_shot import DarkShot
from sensor.effects.fpn import Fpn
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.prism import sensors
from sensor.protocol import Protocol, Shot
from sensor.simulation import stream_of
from sensor.stream import Stream

Floats = NDArray[np.float64]

FORMAT = "camtruth-truth/1"

PACKAGES = ("camtruth", "mitsuba", "drjit", "numpy", "colour-science")
"""What the pixels of a simulated frame depend on."""


def versions() -> dict[str, str]:
    """Versions of the packages that made the frames."""
    return {name: importlib.metadata.version(name) for name in PACKAGES}


def channels_of(camera: Camera) -> tuple[str, ...]:
    """Names of the channels in what leaves the camera."""
    return ("Y",) if camera.pixels.startswith("mono") else CHANNELS


def population(camera: Camera, longest_exposure_s: float) -> dict[str, dict[str, float]]:
    """The noise parameters of the camera by channel and key, as the distribution has them.

    `dark_shot` and `dsnu` are at the longest exposure; the offsets of the shot and PRNU lines are
    0, because equation (1) has none. Effects that are not of the base camera do not enter.
    """
    gain = camera.gain_dn_per_e
    dark, shot = camera.get(DarkShot), camera.get(PhotonShot)
    fpn, prnu, read = camera.get(Fpn), camera.get(Prnu), camera.get(ReadNoise)
    zero = Colours.of(0.0)
    fpn_e = Colours.of(fpn.sigma_e) if fpn else zero
    read_e = read.sigma_e if read else zero
    ratio = Colours.of(prnu.ratio) if prnu else zero
    pattern_e = _dark_pattern_e(camera, longest_exposure_s)
    dark_e = math.sqrt(dark.current_e_per_s * longest_exposure_s) if dark and shot else 0.0
    table = {}
    for channel in channels_of(camera):
        colour = "G" if channel == "Y" else channel
        g = gain[colour]
        table[channel] = {
            "read": read_e[colour] * g,
            "fpn": fpn_e[colour] * g,
            "dark_shot": dark_e * g,
            "shot_coefficient": math.sqrt(g) if shot else 0.0,
            "shot_offset": 0.0,
            "prnu_slope": ratio[colour],
            "prnu_offset": 0.0,
            "gain": g,
            "dsnu": math.hypot(fpn_e[colour], pattern_e) * g,
            "prnu": ratio[colour],
        }
    return table


def realised(
    camera: Camera, longest_exposure_s: float, protocol: Protocol, where: Backend
) -> dict[str, dict[str, float]]:
    """The noise parameters of this very camera body; see `population`."""
    table = population(camera, longest_exposure_s)
    dark_e = _dark_pattern_e(camera, longest_exposure_s)
    for figures in table.values():
        figures["dsnu"] = dark_e * figures["gain"]  # and the fixed offsets, once both are known
    own = ((Fpn, ("fpn",)), (Prnu, ("prnu", "prnu_slope")), (DarkShot, ("dsnu",)))
    for kind, keys in own:
        effect: Effect | None = camera.get(kind)
        if effect is None:
            continue
        drawn = _drawn(camera, effect, protocol.shot[0], where)
        for channel, figures in table.items():
            spread = float(drawn["G" if channel == "Y" else channel].std())
            for key in keys:
                figures[key] *= spread
    for figures in table.values():
        figures["dsnu"] = math.hypot(figures["fpn"], figures["dsnu"])
    return table


def _drawn(camera: Camera, effect: Effect, shot: Shot, where: Backend) -> dict[str, Floats]:
    """The numbers that an effect has drawn for the photosites of each colour."""

    def pattern(one: Camera) -> Floats:
        stream = stream_of(one, effect, shot, 0, range(1), where)
        draw = effect.pattern if isinstance(effect, DarkShot) else _white
        numbers = np.asarray(draw(stream, one.height, one.width).numpy(), dtype=np.float64)
        return numbers.reshape(one.height, one.width)

    if camera.cfa == PRISM:
        return {colour: pattern(one) for colour, one in sensors(camera).items()}
    whole, index = pattern(camera), camera.format.colour_index
    return {colour: whole[index == k] for k, colour in enumerate(CHANNELS)}


def _white(stream: Stream, height: int, width: int) -> Any:
    return stream.body.normal(height, width)


def _dark_pattern_e(camera: Camera, exposure_s: float) -> float:
    """What dark current leaves of a pattern that differs from photosite to photosite."""
    dark = camera.get(DarkShot)
    return dark.spread_e_per_s * exposure_s if dark else 0.0


def truth(
    camera: Camera,
    protocol: Protocol,
    seed: int,
    *,
    light: Mapping[str, Any] | None = None,
    where: Backend | None = None,
) -> dict[str, Any]:
    """The truth record of a capture, as the contract spells it.

    Args:
        camera: the camera.
        protocol: the shots.
        seed: seed of what is not fixed in the body.
        light: what is known of each lamp's rate image, plain data.
        where: the backend that drew the body's patterns.
    """
    longest = max(shot.exposure_s for shot in protocol.shot)
    expected = population(camera, longest)
    actual = realised(camera, longest, protocol, where or backend())
    return {
        "format": FORMAT,
        "seed": seed,
        "body_seed": camera.body_seed,
        "versions": versions(),
        "backend": (where or backend()).name,
        "camera": camera.name,
        "gain_dn_per_e": camera.gain_dn_per_e.plain(),
        "black_dn": camera.black_dn,
        "sensitivity": camera.sensitivity.plain(),
        "protocol": protocol.name,
        "light": dict(light or {}),
        "effects": [
            {
                "name": effect.name,
                "parameters": {
                    p.name: {"value": effect.values()[p.name], "unit": p.unit}
                    for p in effect.parameters()
                },
            }
            for effect in camera.effects
        ],
        "noise": {
            channel: {
                key: {"population": expected[channel][key], "realised": actual[channel][key]}
                for key in expected[channel]
            }
            for channel in expected
        },
    }
