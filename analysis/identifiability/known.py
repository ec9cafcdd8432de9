"""A camera whose figures are known, set up as the diagnosis would have it after calibration."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base, Body
from analysis.gap.camera.light import Light
from analysis.gap.camera.twin import Scenery, shots_of
from analysis.gap.look.arithmetic import IN_FRACTIONS
from analysis.gap.look.lattices import BORDER_PX, lattices_of
from analysis.gap.look.observation import BLOCKS_DOWN, View
from analysis.gap.look.shots import GROUP_FRAMES
from foundation.panel import Panel
from render import path_traced
from render.rate import RateImage
from scenes import scene as scenes
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effects.dark_shot import DarkShot
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Protocol, Shot
from sensor.record import record

Floats = NDArray[np.float64]
Rate = NDArray[np.float32]

PATHS = 64
"""Light paths per pixel: 1e-4 of the light, below everything that is looked for."""


def small_light(name: str, width: int, height: int, samples: int = PATHS) -> dict[str, RateImage]:
    """Rate images of a scene by lamp on few pixels, each as bright as in the full picture.

    Args:
        name: preset or file of the scene.
        width, height: pixels.
        samples: light paths per pixel.

    Raises:
        SceneError: for an unknown scene.
    """
    scene = scenes.load(name)
    # the pitch follows the width, and with it the light that a pixel gathers
    share = np.float32((width / scene.detector.width_px) ** 2)
    small = scene.with_size(width, height)
    return {
        lamp: dataclasses.replace(image, rate_e_per_s=image.rate_e_per_s * share)
        for lamp in small.lamp_names
        for image in [path_traced.render(small, lamp, samples=samples)]
    }


def base_of(camera: Camera, lamps: Sequence[str]) -> Base:
    """The base figures of a camera whose effects are known; the light is that of rate images."""
    channels = ("Y",) if camera.pixels.startswith("mono") else ("R", "G", "B")

    def values(of: Any) -> Floats:
        colours = Colours.of(of)
        return np.array([colours.G if c == "Y" else getattr(colours, c) for c in channels])

    gain = values(camera.gain_dn_per_e)
    zero = np.zeros(len(channels))
    read, fpn, prnu = camera.get(ReadNoise), camera.get(Fpn), camera.get(Prnu)
    dark, filled = camera.get(DarkShot), camera.get(Demosaic)
    return Base(
        channels=channels,
        gain_dn_per_e=gain,
        read_dn2=zero if read is None else np.square(values(read.sigma_e) * gain),
        fpn_dn2=zero if fpn is None else np.square(values(fpn.sigma_e) * gain),
        prnu2=zero if prnu is None else np.square(values(prnu.ratio)),
        black_dn=zero + camera.black_dn,
        dark_e_per_s=0.0 if dark is None else dark.current_e_per_s,
        shown_e_per_s=0.0 if dark is None else dark.shown_e_per_s,
        dark_spread2=0.0 if dark is None else dark.spread_e_per_s**2,
        dark_uneven=0.0 if dark is None else dark.uneven,
        clamp_e2=0.0 if read is None else read.clamp_e**2,
        arithmetic=IN_FRACTIONS if filled is None else int(filled.arithmetic),
        corners=filled is not None and bool(filled.corners),
        white_balance=None,
        blur_px2=0.0,
        level={lamp: values(camera.sensitivity) for lamp in lamps},
    )


def scenery_of(
    camera: Camera,
    shots: Sequence[Shot],
    rates: Mapping[str, Rate],
    panels: Sequence[Panel] = (),
    frames: int = GROUP_FRAMES,
) -> Scenery:
    """Shots of a known light as the diagnosis would look at them.

    Args:
        camera: whose frames they are.
        shots: under one lamp each.
        rates: the light by lamp, (H, W, 3).
        panels: areas of one reflectance.
        frames: in a group.
    """
    dark = Shot(label="dark", exposure_s=0.001, frames=1)
    blank = record(camera, Protocol(name="blank", shot=(dark,)), {})
    lattices = lattices_of(blank)
    down = (min(camera.height, camera.width * 3 // 4) - 2 * BORDER_PX) // lattices[0].step
    first = blank.frames[0]
    wanted = shots_of(shots)
    lamps = {name for shot in wanted if not shot.dark for name in shot.light}
    return Scenery(
        body=Body.of(first, camera.cfa, camera.name),
        light=Light(
            rates={lamp: rates[lamp] for lamp in rates if lamp in lamps},
            noise={},
            panels=tuple(panels),
            known=True,
            source="a known light",
        ),
        shots=wanted,
        view=View(
            lattices=lattices,
            frames=frames,
            side=max(1, -(-down // BLOCKS_DOWN)),
            top_dn=first.top_dn,
        ),
        rules=(),
    )
