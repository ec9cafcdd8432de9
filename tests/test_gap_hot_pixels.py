"""Hot photosites are told by how many samples stand out of the dark, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.hot_pixels import healed, leaking, leaks_of
from sensor.frames import Frames
from sensor.protocol import Shot

GREY = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)
GAIN_DN_PER_E = 0.05
BLACK_DN, SIGMA_DN = 6.0, 0.8
FRAMES, HEIGHT, WIDTH = 16, 240, 320


def dark(mean_dn: np.ndarray, noise_dn: np.ndarray) -> Frames:
    """A dark shot of whole codes."""
    shot = Shot(label="dark", light=(), level=(), exposure_s=0.002, frames=FRAMES)
    codes = np.clip(np.round(BLACK_DN + mean_dn + noise_dn), 0, 255).astype(np.uint8)
    return Frames(shot=shot, dn=codes, pixels="mono8", bits=8, cfa=None)


def noise(seed: int) -> np.ndarray:
    """Normal noise in time."""
    return SIGMA_DN * np.random.default_rng(seed).standard_normal((FRAMES, HEIGHT, WIDTH))


@pytest.mark.parametrize(
    ("density", "excess_e"),
    [(0.0001, 1000.0), (0.001, 400.0), (0.003, 600.0), (0.003, 4000.0)],
    ids=["a handful", "few", "many", "some at the largest code"],
)
def test_density_and_excess_are_those_of_an_exponential(density: float, excess_e: float) -> None:
    """The number of leaking samples is Poisson and the mean of n exponential ones has the relative
    error 1 / sqrt(n), n those below the largest code: at 4 standard errors for 8 figures here."""
    rng = np.random.default_rng(7)
    hot = rng.uniform(size=(HEIGHT, WIDTH)) < density
    excess_dn = GAIN_DN_PER_E * rng.exponential(excess_e, (HEIGHT, WIDTH))
    found = leaking(dark(hot * excess_dn, noise(8)), GREY, {"Y": GAIN_DN_PER_E})
    assert found is not None
    number = hot.sum()
    below = (hot & (excess_dn < 255 - BLACK_DN)).sum()
    assert found[0] == pytest.approx(density, rel=4 / np.sqrt(number))
    assert found[1] == pytest.approx(excess_e, rel=4 / np.sqrt(below))
    assert number / 2 < found[2] <= below


def test_nothing_leaks_where_a_pattern_is_normal_or_noise_has_tails() -> None:
    """A normal pattern as wide as the noise, and tails of equal variance that move from frame to
    frame, which is what a hot photosite is not."""
    rng = np.random.default_rng(9)
    pattern = SIGMA_DN * rng.standard_normal((HEIGHT, WIDTH))
    assert leaking(dark(pattern, noise(10)), GREY, {"Y": GAIN_DN_PER_E}) is None
    flashes = rng.exponential(30.0, (FRAMES, HEIGHT, WIDTH))
    flashes *= rng.uniform(size=flashes.shape) < 0.003
    moving = noise(11) + flashes
    assert leaking(dark(np.zeros_like(pattern), moving), GREY, {"Y": GAIN_DN_PER_E}) is None


def test_frames_are_healed_where_they_leak_and_nowhere_else() -> None:
    """The median of 25 normal samples has a variance of pi / 50 that of one: means of a hot sample
    over its 16 frames scatter about black by less than those of any other, at 5 standard errors
    and half a code. Frames of other shots are healed in the same places."""
    rng = np.random.default_rng(12)
    hot = rng.uniform(size=(HEIGHT, WIDTH)) < 0.003
    leaks = dark(hot * 120.0, noise(13))
    lit = dark(hot * 60.0 + 40.0, noise(14))
    where = [(lattice, leaks_of(leaks, lattice).where) for lattice in GREY]
    for stack, level_dn in ((leaks, BLACK_DN), (lit, BLACK_DN + 40.0)):
        mended = healed(stack, where).dn.mean(axis=0)[8:-8, 8:-8]
        inner = hot[8:-8, 8:-8]
        assert np.abs(mended[inner] - level_dn).max() < 5 * SIGMA_DN / np.sqrt(FRAMES) + 0.5
        assert (mended == stack.dn.mean(axis=0)[8:-8, 8:-8])[~inner].all()
