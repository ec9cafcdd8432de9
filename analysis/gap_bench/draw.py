"""Cameras with random figures, and what they record: every case has a base of its own.

A diagnosis that knew the base would find anything. Here each figure of the base is drawn anew for
every case from a range in which cheap cameras lie, so that it has to be calibrated from the frames.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.gap.look.arithmetic import OF_SIXTEENTHS, OF_SIXTEENTHS_UP
from analysis.gap.measure.signature import comes_in_steps, scaled
from analysis.gap_bench.cases import Case
from analysis.identifiability.limits import Limit, default_of, effect_of
from render.rate import RateImage
from sensor import protocol
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.catalogue import effect
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.dark_shot import DarkShot
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.effects.white_balance import WhiteBalance
from sensor.frames import Capture
from sensor.protocol import Protocol
from sensor.record import record

CAMERA = "icx098"
"""Format and mosaic; all figures are drawn."""

BRIGHTNESS_DN_PER_E = 0.0145
"""Gain at which the rate images fill three quarters of 8 bits; sensitivity follows the gain."""

GAIN_DN_PER_E = (0.008, 0.04)
COLOURS = (0.85, 1.18)
READ_DN = (0.3, 1.5)
FPN_DN = (0.08, 0.5)
PRNU = (0.005, 0.02)
BLACK_DN = (3.0, 8.0)
DARK_E_PER_S = (10.0, 500.0)
BRIGHTER = (0.8, 1.1)

INTERVAL_S = 0.0667


ARITHMETICS = 4
IN_SIXTEENTHS = (OF_SIXTEENTHS, OF_SIXTEENTHS_UP)
FINER = 3
"""Of so many cameras one has a converter of four more bits, with a white balance behind it."""

UNEVEN = (0.0, 0.6)
"""Spread of dark current over the photosites, relative to its mean; log-normal in every other
camera."""

BLACK_PIXELS = (150.0, 10_000.0)
"""Optically black pixels that the clamp of every other camera averages; others have no noise."""


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """The figures of a base camera.

    Attributes:
        gain: DN/e- of each colour as it leaves the camera.
        read_dn: read noise of green.
        fpn_dn: offsets of green photosites.
        prnu: relative spread of the photosites' responses.
        black_dn: black level.
        dark_e_per_s: dark current.
        brighter: sensitivity, relative to the one that fills three quarters of the range.
        shown: part of the dark current that no clamp takes off.
        uneven: spread of the dark current over the photosites, relative to its mean.
        log_normal: whether that spread is.
        black_pixels: how many the clamp averages.
        arithmetic: of the demosaicer.
        finer: whether the converter has four more bits, with a white balance behind it.
    """

    gain: Colours
    read_dn: float
    fpn_dn: float
    prnu: float
    black_dn: float
    dark_e_per_s: float
    brighter: float
    shown: float = 0.0
    uneven: float = 0.0
    log_normal: bool = False
    black_pixels: float = np.inf
    arithmetic: int = 0
    finer: bool = False


def middle(height: int, width: int) -> Camera:
    """The camera in the middle of all ranges: detection limits are its."""

    def centre(low: float, high: float) -> float:
        return float(np.sqrt(low * high))

    figures = Drawn(
        gain=Colours.of(centre(*GAIN_DN_PER_E)),
        read_dn=centre(*READ_DN),
        fpn_dn=centre(*FPN_DN),
        prnu=centre(*PRNU),
        black_dn=float(np.mean(BLACK_DN)),
        dark_e_per_s=centre(*DARK_E_PER_S),
        brighter=float(np.mean(BRIGHTER)),
    )
    return _camera(height, width, figures)


def random_camera(number: int, height: int, width: int) -> Camera:
    """A camera whose base figures are all drawn; noise figures evenly in their logarithm."""
    draw = np.random.default_rng(number)

    def even(low: float, high: float) -> float:
        return float(draw.uniform(low, high))

    def log(low: float, high: float) -> float:
        return float(np.exp(draw.uniform(np.log(low), np.log(high))))

    gain = even(*GAIN_DN_PER_E)
    figures = Drawn(
        gain=Colours(R=gain * log(*COLOURS), G=gain, B=gain * log(*COLOURS)),
        read_dn=log(*READ_DN),
        fpn_dn=log(*FPN_DN),
        prnu=log(*PRNU),
        black_dn=even(*BLACK_DN),
        dark_e_per_s=log(*DARK_E_PER_S),
        brighter=even(*BRIGHTER),
        shown=even(0.0, 1.0),
        arithmetic=int(draw.integers(ARITHMETICS)),
        uneven=even(*UNEVEN),
        log_normal=bool(draw.integers(2)),
        black_pixels=log(*BLACK_PIXELS) if draw.integers(2) else np.inf,
        finer=not draw.integers(FINER),
    )
    return _camera(height, width, figures)


def _camera(height: int, width: int, drawn: Drawn) -> Camera:
    colours, green = drawn.gain, drawn.gain.G
    read_e, dark_e_per_s = drawn.read_dn / green, drawn.dark_e_per_s
    plain = dataclasses.replace(
        load(CAMERA).resized(height, width),
        gain_dn_per_e=Colours.of(green) if drawn.finer else colours,
        black_dn=drawn.black_dn,
        sensitivity=colours.map(lambda g: BRIGHTNESS_DN_PER_E * drawn.brighter / g),
    )
    arithmetic = drawn.arithmetic
    if drawn.finer:
        plain = plain.plus(WhiteBalance(red_gain=colours.R / green, blue_gain=colours.B / green))
        arithmetic = IN_SIXTEENTHS[arithmetic % len(IN_SIXTEENTHS)]
    return plain.plus(
        Prnu(ratio=drawn.prnu),
        Fpn(sigma_e=drawn.fpn_dn / green),
        ReadNoise(
            reset_e=0.0,
            other_e=0.0,
            thermal_e=read_e,
            clamp_e=read_e / float(np.sqrt(drawn.black_pixels)),
        ),
        DarkShot(
            current_e_per_s=dark_e_per_s,
            shown_e_per_s=drawn.shown * dark_e_per_s,
            spread_e_per_s=drawn.uneven * dark_e_per_s,
            uneven=drawn.uneven if drawn.log_normal else 0.0,
        ),
        Demosaic(arithmetic=float(arithmetic)),
    )


def paper(frames: int) -> Protocol:
    """The paper's shots with so many frames each."""
    known = protocol.load("paper")
    return dataclasses.replace(
        known,
        shot=tuple(
            dataclasses.replace(shot, frames=frames, interval_s=INTERVAL_S) for shot in known.shot
        ),
    )


USUAL = {"bits": (1.0, 3.0), "quality": (70.0, 98.0)}
"""Whole numbers of which an effect's range has more than anybody uses; others are all drawn."""


def begun(case: Case) -> list[Effect]:
    """The effects of a case before their strength is looked for; what comes in steps is drawn as
    it will be, every choice evenly.
    """
    draw = np.random.default_rng((case.number, 3))
    return [_drawn(default_of(effect(name)), draw) for name in case.effects]


def _drawn(plain: Effect, draw: np.random.Generator) -> Effect:
    if not comes_in_steps(plain):
        return plain
    chosen: dict[str, float] = {}
    for p in plain.parameters():
        if p.whole:
            low, high = USUAL.get(p.name, (p.minimum, p.maximum))
            chosen[p.name] = float(
                draw.choice([v for v in np.arange(low, high + 1) if v != p.identity])
            )
    return dataclasses.replace(plain, **chosen)


def effects_of(case: Case, limits: Mapping[str, Limit]) -> tuple[Effect, ...] | str:
    """The effects of a case at their strength, or why there is no such case."""
    made = []
    for name in case.effects:
        limit = limits[name]
        least = effect_of(limit, effect(name))
        if limit.steps:
            made.append(least)
            continue
        if not limit.reached:
            return f"{name} is not seen by this protocol at its strongest"
        strong = scaled(least, case.strength)
        if not at_strength(least, strong, case.strength):
            return f"{name} cannot be {case.strength:.2g} detection limits strong"
        made.append(strong)
    return tuple(made)


def at_strength(least: Effect, strong: Effect, severity: float) -> bool:
    """Whether an effect could be made so strong within its range."""
    back = scaled(strong, 1 / severity)
    return all(
        np.isclose(getattr(back, p.name), getattr(least, p.name), rtol=1e-6, atol=1e-12)
        for p in least.parameters()
        if isinstance(getattr(least, p.name), (int, float))
    )


def camera_of(case: Case, light: Mapping[str, RateImage]) -> Camera:
    """The camera of a case, without its effects."""
    height, width = next(iter(light.values())).rate_e_per_s.shape[:2]
    return random_camera(case.number, height, width)


def capture_of(
    case: Case,
    camera: Camera,
    effects: Sequence[Effect],
    light: Mapping[str, RateImage],
    frames: int,
) -> tuple[Capture, Camera]:
    """The frames of a case, and the camera that took them."""
    camera = camera.plus(*effects).with_body(case.number)
    rates = {lamp: one.rate_e_per_s for lamp, one in light.items()}
    return record(camera, paper(frames), rates, seed=case.number), camera
