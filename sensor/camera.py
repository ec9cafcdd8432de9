"""A camera: its format, its conversion, and the effects along its signal path.

The paper's equation (1),

    N_cap = (I x PRNU + SN_ph(I) + I + FPN + SN_dark + N_read) x N_D x N_filt + N_Q,

is the camera whose effects are `prnu`, `dark_shot`, `photon_shot`, `fpn`, `read_noise`, `demosaic`
and `quantization`. N_filt is whatever stands in the processing stage after the demosaicer; by
default nothing does, which is the paper's identity.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.demosaic import Demosaic
from sensor.effects.quantization import Quantization
from sensor.errors import CameraError
from sensor.frames import MOSAIC_WORDS, MOSAICS, PIXELS, Pixels
from sensor.signal import Format

GREY = "GGGG"
"""The `cfa` of a camera without a mosaic."""

BEHIND_A_FILTER = ("RRRR", "BBBB")
"""The same behind a filter of another colour, as two of three sensors are."""

PRISM = "RGB"
"""The `cfa` of a camera of three sensors behind a prism, each of which sees one colour."""

E = TypeVar("E", bound=Effect)


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A camera body.

    Attributes:
        name: what to call it.
        width, height: pixels.
        pixels: what leaves it: rgb8, bayer8, bayer16, mono8 or mono16.
        bits: significant bits of a pixel.
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1); ``"GGGG"`` without a mosaic, ``"RGB"``
            of three sensors, with rgb8.
        gain_dn_per_e: conversion by colour.
        black_dn: black level.
        sensitivity: its photo-electrons per photo-electron of the rate image, by colour.
        effects: in physical order.
        body_seed: what makes this body's fixed patterns differ from another's.
    """

    name: str
    width: int = 640
    height: int = 480
    pixels: Pixels = "rgb8"
    bits: int = 8
    cfa: str = "RGGB"
    gain_dn_per_e: Colours
    black_dn: float = 0.0
    sensitivity: Colours = field(default_factory=lambda: Colours.of(1.0))
    effects: tuple[Effect, ...] = ()
    body_seed: int = 0

    def __post_init__(self) -> None:
        grey = self.pixels.startswith("mono") and self.cfa in BEHIND_A_FILTER
        if self.cfa not in (*MOSAICS, GREY, PRISM) and not grey:
            raise CameraError(f"cfa '{self.cfa}'", f"expected {MOSAIC_WORDS}", 'as in "RGGB"')
        if self.cfa == PRISM and (self.pixels != "rgb8" or self.get(Demosaic)):
            raise CameraError(
                f"three sensors that give {self.pixels}"
                f"{' by a demosaicer' if self.get(Demosaic) else ''}",
                "expected rgb8 of which nothing is filled in",
                "correct pixels or cfa, or remove the effect 'demosaic'",
            )
        if not 1 <= self.bits <= 8 * np.dtype(PIXELS[self.pixels][1]).itemsize:
            raise CameraError(
                f"{self.bits} bits in {self.pixels}", "expected them to fit", "correct one of them"
            )
        if min(self.gain_dn_per_e) <= 0 or min(self.sensitivity) < 0:
            raise CameraError(
                f"camera '{self.name}' with a gain that is not above 0 or a negative sensitivity",
                "expected positive figures",
                "correct gain_dn_per_e or sensitivity",
            )
        for first, second in zip(self.effects, self.effects[1:], strict=False):
            if first.name == second.name:
                raise CameraError(
                    f"effect '{first.name}' twice", "expected each effect once", "remove one"
                )
            if first.place() > second.place():
                raise CameraError(
                    f"effect '{first.name}' before effect '{second.name}'",
                    f"expected the order of the signal path: '{second.name}' comes first",
                    "swap them",
                )

    @property
    def format(self) -> Format:
        """What its effects may know of it."""
        return Format(
            height=self.height,
            width=self.width,
            cfa=self.cfa,
            bits=self.bits,
            gain_dn_per_e=self.gain_dn_per_e,
            black_dn=self.black_dn,
        )

    @property
    def cfa_of_pixels(self) -> str | None:
        """The colours of the pixels as a capture states them: none for one without a mosaic."""
        return self.cfa if self.cfa in MOSAICS and not self.pixels.startswith("mono") else None

    @property
    def chain(self) -> tuple[Effect, ...]:
        """The effects that a signal meets: nothing is rounded where a later one does that."""
        by_itself = any(effect.rounds for effect in self.effects)
        return tuple(e for e in self.effects if not (by_itself and isinstance(e, Quantization)))

    @property
    def history_frames(self) -> int:
        """How many frames must run in before the first one."""
        return sum(effect.history_frames for effect in self.effects)

    def get(self, kind: type[E]) -> E | None:
        """The effect of a kind, if this camera has it."""
        return next((effect for effect in self.effects if isinstance(effect, kind)), None)

    def plus(self, *effects: Effect) -> Camera:
        """The same camera with more effects, each in its place; one it has is replaced."""
        names = {effect.name for effect in effects}
        kept = [effect for effect in self.effects if effect.name not in names]
        ordered = sorted([*kept, *effects], key=lambda effect: effect.place())
        return dataclasses.replace(self, effects=tuple(ordered))

    def without(self, *kinds: type[Effect]) -> Camera:
        """The same camera with some kinds of effect taken out."""
        return dataclasses.replace(
            self, effects=tuple(e for e in self.effects if not isinstance(e, kinds))
        )

    def with_body(self, body_seed: int) -> Camera:
        """Another body of the same make."""
        return dataclasses.replace(self, body_seed=body_seed)

    def resized(self, height: int, width: int) -> Camera:
        """The same camera with another number of pixels: a crop that keeps the colour phase."""
        return dataclasses.replace(self, height=height, width=width)
