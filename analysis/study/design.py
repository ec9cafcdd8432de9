"""The factors of the study and their levels: every combination is a cell."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, fields

LAMP_PLACES: Mapping[str, tuple[float, float, float]] = {
    "even": (0.05, -0.15, 0.45),
    "gentle": (-0.10, -0.15, 0.45),
    "paper": (-0.0825, 0.4675, 0.45),
    "near": (-0.15, -0.10, 0.15),
    "close": (-0.10, -0.05, 0.06),
}
"""Where the lamp stands, from the middle of the panel, in m; z off the chart. "paper" is where the
preset scene has its incandescent lamp; "even" makes up for the fall-off of the lens."""

LAMPS = ("incandescent", "fluorescent")
"""Lamps of the preset scene, here without the gels that make their colours alike."""

BITS = (8, 10, 12)
ELECTRONS_PER_DN8 = (4.0, 20.0, 66.0)
"""Electrons for a step of 8 bits: the paper's green, its red, and the area-scaled estimate."""

NOISE_STEPS = (0.1, 0.2, 0.35, 0.5, 1.0, 2.0)
"""Read noise in steps of the camera's own bits."""

BLUR_PX = (0.0, 6.0)
"""Further defocus."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One combination of the factors."""

    place: str
    lamp: str
    bits: int
    electrons_per_dn8: float
    noise_steps: float
    blur_px: float

    @property
    def key(self) -> str:
        """The case in one word."""
        return "/".join(f"{getattr(self, f.name)}" for f in fields(self))

    @property
    def step_dn8(self) -> float:
        """A step of this camera in DN of 8 bits."""
        return 2.0 ** (8 - self.bits)


def cases() -> dict[str, Case]:
    """All combinations by key: 1080."""
    found = [
        Case(
            place=place,
            lamp=lamp,
            bits=bits,
            electrons_per_dn8=electrons,
            noise_steps=noise,
            blur_px=blur,
        )
        for place, lamp, bits, electrons, noise, blur in itertools.product(
            LAMP_PLACES, LAMPS, BITS, ELECTRONS_PER_DN8, NOISE_STEPS, BLUR_PX
        )
    ]
    return {case.key: case for case in found}
