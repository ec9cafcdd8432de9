"""The rendered light of one panel with the lamp moved, and the camera in front of it.

One grey panel near the middle of the image, in the dark and at two levels of the lamp, by a camera
that gives its mosaic as it is: no demosaic stands between rounding and the estimators. FPN and PRNU
stay the same in all cells; the black level lies a third of a step off a code, well above 0.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.study.design import LAMP_PLACES, Case
from foundation.panel import Panel
from render.closed_form import render
from scenes.geometry import analysis_panels, panel_rectangles
from scenes.scene import load as load_scene
from sensor.camera import Camera
from sensor.catalogue import effect
from sensor.colours import Colours
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import Protocol, Shot

PANEL = "22"
FPN_DN8 = 0.2
PRNU = 0.01
BLACK_DN8 = 8.0
PHASE = 0.3
"""Where black lies between two codes, in steps."""

BRIGHTEST_DN8 = 150.0
"""Mean over black of the brightest colour at level 1."""

LEVELS = (0.3, 1.0)
EXPOSURE_S = 0.03268
FRAMES = 100


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A camera of the size of a panel and its margin, the light on it, and its truth.

    Attributes:
        rise_dn8: how far light rises over the panel at level 1, by colour, in DN of 8 bits: along
            the slope of the best plane, so that its variance is rise^2 / 12 however it lies.
    """

    camera: Camera
    protocol: Protocol
    rates: Mapping[str, NDArray[np.float32]]
    panel: Panel
    rise_dn8: Mapping[str, float]
    truth: Mapping[str, float]


@functools.lru_cache(maxsize=32)
def panel_light(place: str, lamp: str) -> tuple[NDArray[np.float32], Panel]:
    """Light relative to its brightest colour's mean over the panel: a strip that holds it."""
    scene = load_scene("chart")
    where = panel_rectangles(scene)[PANEL]
    dx, dy, z = LAMP_PLACES[place]
    x, y = (where.left_m + where.right_m) / 2 + dx, (where.bottom_m + where.top_m) / 2 + dy
    lamps = tuple(dataclasses.replace(own, position_m=(x, y, z), filter=None) for own in scene.lamp)
    moved = dataclasses.replace(scene, lamp=lamps)
    rate = render(moved, lamp).rate_e_per_s
    (panel,) = analysis_panels(scene, (PANEL,))
    return rate / rate[panel.window].mean(axis=(0, 1)).max(), panel


def bench(case: Case) -> Bench:
    """What a case simulates."""
    light, panel = panel_light(case.place, case.lamp)
    scale = 2.0 ** (case.bits - 8)
    gain = scale / case.electrons_per_dn8
    settings = {
        "prnu": {"ratio": PRNU},
        "photon_shot": {},
        "fpn": {"sigma_e": FPN_DN8 * case.electrons_per_dn8},
        "read_noise": {"reset_e": 0.0, "thermal_e": case.noise_steps / gain, "other_e": 0.0},
        "quantization": {},
    }
    if case.blur_px:
        settings = {"defocus_error": {"diameter_px": case.blur_px}} | settings
    height, width, _ = light.shape
    whole = Camera(
        name="study",
        width=width,
        height=height,
        pixels="bayer16",
        bits=case.bits,
        gain_dn_per_e=Colours.of(gain),
        black_dn=BLACK_DN8 * scale + PHASE,
        effects=tuple(effect(name).with_parameters(of) for name, of in settings.items()),
    )
    rate = light * np.float32(BRIGHTEST_DN8 * scale / gain / EXPOSURE_S)
    camera, rates, (cut,) = panels_only(whole, {case.lamp: rate}, [panel])
    return Bench(
        camera=camera,
        protocol=_protocol(case.lamp),
        rates=rates,
        panel=cut,
        rise_dn8={
            c: BRIGHTEST_DN8 * _rise(light[panel.window][..., k]) for k, c in enumerate("RGB")
        },
        truth={
            "read": case.noise_steps,
            "gain": gain,
            "fpn": FPN_DN8 * scale,
            "prnu": PRNU,
            "shot_coefficient": gain**0.5,
            "prnu_slope": PRNU,
        },
    )


def _protocol(lamp: str) -> Protocol:
    def shot(label: str, level: float | None) -> Shot:
        return Shot(
            label=label,
            light=(lamp,) if level else ("none",),
            level=(level or 1.0,),
            exposure_s=EXPOSURE_S,
            frames=FRAMES,
        )

    return Protocol(
        name="study", shot=(shot("dark", None), *(shot(f"lit-{v:g}", v) for v in LEVELS))
    )


def _rise(light: NDArray[np.float32]) -> float:
    """How far the best plane through light (h, w) rises over a panel's side along its slope."""
    h, w = light.shape
    y, x = np.mgrid[-0.5 : 0.5 : h * 1j, -0.5 : 0.5 : w * 1j]
    design = np.stack([np.ones(h * w), x.ravel(), y.ravel()], axis=1)
    _, a, b = np.linalg.lstsq(design, light.ravel().astype(np.float64), rcond=None)[0]
    return float(np.hypot(a, b))
