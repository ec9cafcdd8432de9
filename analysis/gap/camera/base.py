"""The base camera: the figures of the paper's model that every capture is calibrated to.

    DN = black + gain x (charge x (1 + PRNU) + shot noise of charge and dark charge) + FPN + read

Noise figures are kept as variances in DN^2: an estimate of a variance may come out below zero by
chance, and what is left out of one of them is taken up by another without a bend.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.blur import Blur, Within
from sensor.camera import PRISM, Camera
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effects.white_balance import WhiteBalance
from sensor.frames import Frames, Pixels
from sensor.interpolation import COUNTING

Floats = NDArray[np.float64]


MOST_DARK_E_PER_S = 9e5
MOST_UNEVEN = 1.5
MOST_BLUR_PX2 = 50.0
"""Up to which calibration turns the dark current, its unevenness, and the variance of the blur: the
first two are inside the ranges of the parameters of `dark_shot`."""

LEFT_OF_GREEN = 5 / 16
"""Of the variance of a measured green that is averaged with those at its corners."""

FEWEST_BLACK = 25
"""Optically black pixels that a clamp averages at least."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Base:
    """A calibrated camera and the level of its light.

    Attributes:
        channels: R, G, B, or Y alone.
        gain_dn_per_e: conversion, per channel.
        read_dn2: variance of the read noise, per channel.
        fpn_dn2: variance of the fixed offsets, per channel.
        prnu2: variance of the response relative to its mean, per channel.
        black_dn: black level, per channel: a gain behind the converter multiplies it too.
        dark_e_per_s: dark current, which brings its shot noise.
        shown_e_per_s: the part of its mean that grows in the frames with the exposure.
        dark_spread2: its variance over the photosites, in e-^2/s^2.
        dark_uneven: u of the law that it follows there; see `DarkShot`.
        clamp_e2: variance of what the pixels of a frame share, in e-^2: the clamp's own noise.
        arithmetic: how the demosaicer counts, or the converter without one; see `arithmetic_of`.
        corners: whether the demosaicer averages measured greens with those at their corners.
            Figures above are those before that.
        white_balance: of whole codes or finer ones, behind it; None without. Gains, levels and
            variances above are those before it.
        origin_dn: the code that it leaves alone, where combs tell it; else the mean black level.
        blur_px2: variance by which the picture is softer than its light, along each axis.
        within: what that light is like within pixels; see `Blur`.
        level: electrons per unit of the light, by lamp, each per channel.
    """

    channels: tuple[str, ...]
    gain_dn_per_e: Floats
    read_dn2: Floats
    fpn_dn2: Floats
    prnu2: Floats
    black_dn: Floats
    dark_e_per_s: float
    shown_e_per_s: float
    dark_spread2: float
    dark_uneven: float
    clamp_e2: float
    arithmetic: int
    corners: bool = False
    white_balance: WhiteBalance | None
    origin_dn: float | None = None
    blur_px2: float
    within: Within = "points"
    level: Mapping[str, Floats]

    def moved(self, name: str, channel: int | None, by: float) -> Base:
        """The base with one figure changed; variances stay above zero, `gain` and `level` factors.

        Args:
            name: gain, read, fpn, prnu, black, dark, shown, spread, uneven, clamp, blur, or
                level:LAMP.
            channel: index of the channel; None for all, and for figures without one.
            by: logarithm of the factor for gain and level; the addition for all others.
        """
        step = np.zeros(len(self.channels))
        step[slice(None) if channel is None else channel] = by
        if name.startswith("level:"):
            lamp = name.removeprefix("level:")
            return dataclasses.replace(
                self, level={**self.level, lamp: self.level[lamp] * np.exp(step)}
            )
        match name:
            case "gain":
                factor = np.exp(step)
                # the picture stays as bright: fewer electrons at a higher gain
                return dataclasses.replace(
                    self,
                    gain_dn_per_e=self.gain_dn_per_e * factor,
                    level={lamp: level / factor for lamp, level in self.level.items()},
                )
            case "black":
                return dataclasses.replace(self, black_dn=self.black_dn + step)
            case "dark":
                dark = float(np.clip(self.dark_e_per_s + by, 0, MOST_DARK_E_PER_S))
                return dataclasses.replace(self, dark_e_per_s=dark)
            case "shown":
                most = MOST_DARK_E_PER_S
                shown = float(np.clip(self.shown_e_per_s + by, -most, most))
                return dataclasses.replace(self, shown_e_per_s=shown)
            case "spread":
                return dataclasses.replace(self, dark_spread2=max(self.dark_spread2 + by, 0.0))
            case "uneven":
                uneven = float(np.clip(self.dark_uneven + by, 0.0, MOST_UNEVEN))
                return dataclasses.replace(self, dark_uneven=uneven)
            case "clamp":
                clamp = float(np.clip(self.clamp_e2 + by, 0.0, self.most_of_a_clamp_e2))
                return dataclasses.replace(self, clamp_e2=clamp)
            case "blur":
                blur = float(np.clip(self.blur_px2 + by, 0, MOST_BLUR_PX2))
                return dataclasses.replace(self, blur_px2=blur)
            case _:
                field = {"read": "read_dn2", "fpn": "fpn_dn2", "prnu": "prnu2"}[name]
                values = np.maximum(getattr(self, field) + step, 0.0)
                return dataclasses.replace(self, **{field: values})

    @property
    def blur(self) -> Blur:
        """How its light is softened."""
        return Blur(variance_px2=self.blur_px2, within=self.within)

    @property
    def reference_dn(self) -> float:
        """The black level that the camera is said to have: those of channels are off by offsets."""
        return float(self.black_dn.mean()) if self.origin_dn is None else self.origin_dn

    def multiplied(self, gains: WhiteBalance, origin_dn: float | None = None) -> Base:
        """The camera whose frames look the same, with these gains behind its converter: its figures
        are those in front of them.

        Args:
            gains: come on top of those that it has, about the same code as they.
            origin_dn: that code, where it is known.
        """
        had = self.white_balance
        whole = gains
        if had is not None:
            red, blue = had.red_gain * gains.red_gain, had.blue_gain * gains.blue_gain
            whole = dataclasses.replace(had, red_gain=red, blue_gain=blue)
        origin_dn = self.origin_dn if origin_dn is None else origin_dn
        known = dataclasses.replace(self, origin_dn=origin_dn if whole.about_black else None)
        behind = known._in_front_of(gains, known.reference_dn if whole.about_black else 0.0)
        return dataclasses.replace(behind, white_balance=whole)

    def averaged(self) -> Base:
        """The camera whose frames look the same, with greens averaged with those at their corners:
        its figures are those in front of that.
        """
        factor = np.array([1 / LEFT_OF_GREEN if one == "G" else 1.0 for one in self.channels])
        return dataclasses.replace(self.noisier(factor), corners=True)

    def noisier(self, factor: Floats) -> Base:
        """The camera with so many times the variance in each channel, as bright."""
        return dataclasses.replace(
            self,
            gain_dn_per_e=self.gain_dn_per_e * factor,
            read_dn2=self.read_dn2 * factor,
            fpn_dn2=self.fpn_dn2 * factor,
            prnu2=self.prnu2 * factor,
            level={lamp: level / factor for lamp, level in self.level.items()},
        )

    def plain(self) -> Base:
        """The camera whose frames look the same, but for their combs, without a white balance."""
        had = self.white_balance
        if had is None:
            return self
        back = WhiteBalance(red_gain=1 / had.red_gain, blue_gain=1 / had.blue_gain)
        before = self._in_front_of(back, self.reference_dn if had.about_black else 0.0)
        return dataclasses.replace(before, white_balance=None, origin_dn=None)

    @property
    def gain_of_balance(self) -> Floats:
        """By how much the white balance multiplies each channel: (channels,)."""
        return self._gains_of(self.white_balance or WhiteBalance(red_gain=1.0, blue_gain=1.0))

    def _gains_of(self, balance: WhiteBalance) -> Floats:
        by_name = {"R": balance.red_gain, "B": balance.blue_gain}
        return np.array([by_name.get(channel, 1.0) for channel in self.channels])

    def _in_front_of(self, gains: WhiteBalance, origin_dn: float) -> Base:
        """Figures that are those of this camera behind some gains."""
        k = self._gains_of(gains)
        return dataclasses.replace(
            self,
            gain_dn_per_e=self.gain_dn_per_e / k,
            read_dn2=self.read_dn2 / k**2,
            fpn_dn2=self.fpn_dn2 / k**2,
            black_dn=origin_dn + (self.black_dn - origin_dn) / k,
        )

    @property
    def most_of_a_clamp_e2(self) -> float:
        """Variance in e-^2 of a clamp that averages `FEWEST_BLACK` pixels; more is no clamp's."""
        return float(np.min(self.read_dn2 / np.square(self.gain_dn_per_e))) / FEWEST_BLACK


def channels_alike(base: Base) -> Base:
    """The base with the figures of green in all channels, as bright as it is: that of one converter
    for all colours, where those of red and blue are hidden by tenths of a DN and no small step
    leads back.
    """
    green = base.channels.index("G")
    factor = base.gain_dn_per_e[green] / base.gain_dn_per_e

    def everywhere(values: Floats) -> Floats:
        return np.full_like(values, values[green])

    return dataclasses.replace(
        base,
        gain_dn_per_e=everywhere(base.gain_dn_per_e),
        black_dn=everywhere(base.black_dn),
        read_dn2=everywhere(base.read_dn2),
        fpn_dn2=everywhere(base.fpn_dn2),
        prnu2=everywhere(base.prnu2),
        level={lamp: level / factor for lamp, level in base.level.items()},
    )


@dataclass(frozen=True, kw_only=True)
class Body:
    """What is known of the camera without looking at its noise."""

    height: int
    width: int
    pixels: Pixels
    bits: int
    cfa: str
    name: str

    @property
    def fills_in(self) -> bool:
        """Whether two of three colours of each pixel are made of its neighbours."""
        return self.pixels == "rgb8" and self.cfa != PRISM

    @staticmethod
    def of(frames: Frames, cfa: str, name: str) -> Body:
        """The body that took these frames."""
        return Body(
            height=frames.height,
            width=frames.width,
            pixels=frames.pixels,
            bits=frames.bits,
            cfa=cfa,
            name=name,
        )


def camera_of(base: Base, body: Body) -> Camera:
    """The base camera as the sensor's model has it. Its light comes in electrons."""
    gain = base.gain_dn_per_e

    def colours(values: Floats) -> Colours:
        by_name = dict(zip(base.channels, (float(v) for v in values), strict=True))
        if "Y" in by_name:
            return Colours.of(by_name["Y"])
        return Colours(**{c: by_name.get(c, float(np.mean(values))) for c in "RGB"})

    known = catalogue()
    values: dict[str, dict[str, float | Colours]] = {
        "prnu": {"ratio": colours(np.clip(np.sqrt(base.prnu2), 0, 0.2))},
        "dark_shot": {
            "current_e_per_s": base.dark_e_per_s,
            "shown_e_per_s": base.shown_e_per_s,
            "spread_e_per_s": min(base.dark_spread2**0.5, MOST_DARK_E_PER_S),
            "uneven": base.dark_uneven,
        },
        "photon_shot": {},
        "fpn": {"sigma_e": colours(np.clip(np.sqrt(base.fpn_dn2) / gain, 0, 1000))},
        "read_noise": {
            "reset_e": 0.0,
            "thermal_e": colours(np.clip(np.sqrt(base.read_dn2) / gain, 0, 1000)),
            "other_e": 0.0,
            "clamp_e": base.clamp_e2**0.5,
        },
        "quantization": {},
    }
    if body.fills_in:
        values["demosaic"] = {
            "arithmetic": float(base.arithmetic),
            "corners": float(base.corners),
        }
    elif steps := COUNTING[base.arithmetic].steps:
        values["quantization"] = {"steps": steps}
    black_dn = base.reference_dn
    if np.any(base.black_dn != black_dn):
        values["black_level_offset"] = {"offset_e": colours((base.black_dn - black_dn) / gain)}
    effects = [known[name].with_parameters(figures) for name, figures in values.items()]
    if base.white_balance is not None:
        effects.append(base.white_balance)
    return Camera(
        name=body.name,
        width=body.width,
        height=body.height,
        pixels=body.pixels,
        bits=body.bits,
        cfa=body.cfa,
        gain_dn_per_e=colours(gain),
        black_dn=black_dn,
    ).plus(*effects)
