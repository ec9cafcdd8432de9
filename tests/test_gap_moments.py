"""The first figures of a camera are moments of its frames, of places that tell them."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import look
from sensor.frames import Capture, Frames
from sensor.protocol import Shot

HEIGHT, WIDTH, FRAMES = 118, 158, 16
GAIN_DN_PER_E, BLACK_DN, READ_DN, TOP_DN = 0.8, 60.0, 8.0, 4095


def shot(label: str, brightest_e: float, level: float, seed: int) -> Frames:
    """Frames of a light that falls off to a tenth towards the right and the bottom."""
    rng = np.random.default_rng(seed)
    ramp = np.linspace(1.0, 0.1, WIDTH) * np.linspace(1.0, 0.1, HEIGHT)[:, None]
    electrons = rng.poisson(level * brightest_e * ramp, (FRAMES, HEIGHT, WIDTH))
    dn = GAIN_DN_PER_E * electrons + BLACK_DN + READ_DN * rng.standard_normal(electrons.shape)
    light = ("lamp",) if level else ("none",)
    return Frames(
        dn=np.clip(np.round(dn), 0, TOP_DN).astype(np.uint16),
        shot=Shot(label=label, light=light, level=(level or 1.0,), exposure_s=0.01, frames=FRAMES),
        pixels="mono16",
        bits=12,
        cfa=None,
    )


@pytest.mark.parametrize("brightest_e", [4000.0, 8000.0])
def test_the_gain_is_that_of_places_that_tell_it(brightest_e: float) -> None:
    """Noise over signal, both of the same places: what is left of them at the border is darker, by
    4 % of the gain here. At 8,000 e- the brightest shot is clipped in a tenth of the frame, where
    there is no noise; the faint ones tell the gain then. The variance of a shot has n (F - 1)
    degrees of freedom, n its pixels, and two or three shots tell it: 4 standard errors."""
    levels = (0.0, 0.2, 0.3, 1.0)
    frames = [shot(f"{level}", brightest_e, level, seed=k) for k, level in enumerate(levels)]
    setting = look(Capture(camera="x", frames=tuple(frames)), {})
    assert setting is not None
    _, base = by_moments(setting)
    freedom = setting.seen.samples * setting.seen.means.shape[-1] * (FRAMES // 2 - 1)
    error = GAIN_DN_PER_E * np.sqrt(2.0 / freedom)
    assert base.gain_dn_per_e[0] == pytest.approx(GAIN_DN_PER_E, abs=4 * error)
