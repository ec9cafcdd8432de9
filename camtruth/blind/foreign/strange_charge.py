"""What no catalogue has, while the signal is charge: cosmic rays, glow, heavy tails, two taps."""

from __future__ import annotations

import numpy as np

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

E_PER_PX = 900.0
"""Charge that a muon leaves in a pixel: 80 e-/um through some 11 um of silicon."""

LEAST_RAYS = 2e3
"""Of so many in a second and a million pixels, small frames of a short stack have some each."""

TAILS = 3.0
"""Degrees of freedom of the heavy-tailed noise: the fewest with a variance."""

GLOW_REACH = 0.25
"""The amplifier's light falls to 1/e over this part of the frame's diagonal."""


def cosmic_rays(electrons: Numbers, strength: float, about: About) -> Numbers:
    """Straight tracks of charge, `strength` of them in a second and a million pixels on average."""
    out = electrons.copy()
    height, width = out.shape[1:]
    for frame, draw in zip(out, about.draws("cosmic rays"), strict=True):
        for _ in range(draw.poisson(strength * about.exposure_s * height * width / 1e6)):
            steps = np.arange(draw.geometric(0.15))
            angle = draw.uniform(0, 2 * np.pi)
            row = (draw.uniform(0, height) + steps * np.sin(angle)).astype(int)
            column = (draw.uniform(0, width) + steps * np.cos(angle)).astype(int)
            inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
            charge = draw.exponential(E_PER_PX, inside.sum())
            np.add.at(frame, (row[inside], column[inside]), charge)
    return out


def amplifier_glow(electrons: Numbers, strength: float, about: About) -> Numbers:
    """The output amplifier shines on the nearest corner: e- there in a second, with shot noise."""
    height, width = electrons.shape[1:]
    far = np.hypot(np.arange(height)[:, None], np.arange(width)[None, ::-1])
    mean = strength * about.exposure_s * np.exp(-far / (GLOW_REACH * np.hypot(height, width)))
    drawn = [draw.poisson(mean) for draw in about.draws("amplifier glow")]
    return np.asarray(electrons + np.stack(drawn), dtype=electrons.dtype)


def heavy_tails(electrons: Numbers, strength: float, about: About) -> Numbers:
    """Read noise after Student: most pixels barely move, a few by many times `strength` e-."""
    drawn = [draw.standard_t(TAILS, electrons.shape[1:]) for draw in about.draws("heavy tails")]
    return np.asarray(electrons + strength * np.stack(drawn), dtype=electrons.dtype)


def two_taps(electrons: Numbers, strength: float, about: About) -> Numbers:
    """The two halves are read by two amplifiers; the right one's gain is higher by `strength`."""
    out = electrons.copy()
    out[:, :, out.shape[2] // 2 :] *= 1 + strength
    return out


def _own(name: str, act: object, ends: tuple[float, float], stage: str, order: int) -> Outsider:
    return Outsider(
        name=name,
        source="none",
        answers=(),
        stage=stage,
        place="electrons",
        weakest=ends[0],
        strongest=ends[1],
        act=act,  # type: ignore[arg-type]
        order=order,
    )


OUTSIDERS = (
    _own("cosmic_rays", cosmic_rays, (LEAST_RAYS, 1e5), "photosite", 51),
    _own("amplifier_glow", amplifier_glow, (10.0, 1e6), "photosite", 52),
    _own("heavy_tailed_read_noise", heavy_tails, (0.1, 300.0), "readout", 22),
    _own("two_tap_gain", two_taps, (1e-4, 0.2), "readout", 55),
)
