"""Traps are told by pixels that are louder than noise makes them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.loud_pixels import loud
from analysis.gap.ready.random_telegraph_noise import told_by_loud
from sensor.effects.random_telegraph_noise import TOLD_S
from sensor.frames import Frames
from sensor.protocol import Shot

HEIGHT, WIDTH, FRAMES = 176, 216, 40
GAIN_DN_PER_E, BLACK_DN, SIGMA_DN = 0.1, 20.0, 1.0
INTERVAL_S = 0.0667
EXPOSURES_S = 0.08, 0.2, 0.1
GREY = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)


def noise(seed: int) -> NDArray[np.float64]:
    """Normal noise in time."""
    return SIGMA_DN * np.random.default_rng(seed).standard_normal((FRAMES, HEIGHT, WIDTH))


def told(
    *shots: NDArray[np.float64], exposures_s: tuple[float, ...] = EXPOSURES_S
) -> DirectReading | None:
    """What dark shots of a body tell that differ from black by so much."""
    seen = []
    for excess, exposure_s in zip(shots, exposures_s, strict=False):
        dn = np.clip(np.round(BLACK_DN + excess), 0, 255).astype(np.uint8)
        shot = Shot(label="dark", exposure_s=exposure_s, frames=FRAMES, interval_s=INTERVAL_S)
        frames = Frames(dn=dn, shot=shot, pixels="mono8", bits=8, cfa=None)
        seen.append(frames)
    return told_by_loud(loud(seen, GREY, {"Y": GAIN_DN_PER_E}))


def levels(shape: tuple[int, ...], up_s: float, down_s: float, seed: int) -> NDArray[np.bool_]:
    """Chains of two levels looked at once a frame, (FRAMES, ...): each begins where it may be, and
    in a frame either keeps its level or forgets it."""
    rng = np.random.default_rng(seed)
    share_up, stays = up_s / (up_s + down_s), np.exp(-INTERVAL_S * (1 / up_s + 1 / down_s))
    up = rng.uniform(size=(FRAMES, *shape)) < share_up
    for frame in range(1, FRAMES):
        kept = rng.uniform(size=shape) < stays
        up[frame] = np.where(kept, up[frame - 1], up[frame])
    return up


@pytest.mark.parametrize(
    ("fraction", "amplitude_e", "up_s", "down_s", "within", "law"),
    [
        (0.01, 300.0, 0.5, 1.0, 0.2, "exponential"),
        (0.01, 400.0, 3.0, 0.8, 0.4, "exponential"),
        (0.01, 40.0, 0.5, 1.0, 0.25, "exponential"),
        (0.02, 150.0, 0.2, 0.2, 0.2, "alike"),
        (0.01, 400.0, 3.0, 0.8, 0.4, "alike"),
        (0.01, 300.0, 0.5, 1.0, 0.2, "lognormal dark current"),
        (0.02, 150.0, 0.2, 0.2, 0.2, "lognormal dark current"),
    ],
)
def test_a_chain_of_two_levels_is_told(
    fraction: float, amplitude_e: float, up_s: float, down_s: float, within: float, law: str
) -> None:
    """Numbers are Poisson, jumps of one of three laws, and dwell times exponential: at 4 standard
    errors for 33 figures here, and whether jumps are dark current each time. An upper level of 3 s
    lasts longer than a shot, and most jumps of 40 electrons are lost in noise of 10, so that no
    frame shows a level."""
    rng = np.random.default_rng(3)
    has = rng.uniform(size=(HEIGHT, WIDTH)) < fraction
    size = {
        "exponential": rng.exponential(1.0, has.shape),
        "alike": np.ones(has.shape),
        "lognormal dark current": rng.lognormal(-0.5 * 0.5**2, 0.5, has.shape),
    }[law]
    of_dark = law.endswith("dark current")
    jumps_e = amplitude_e * size * has
    shots = []
    for k, exposure_s in enumerate(EXPOSURES_S):
        up_e = jumps_e * levels(has.shape, up_s, down_s, 20 + k)
        if of_dark:
            up_e = rng.poisson(up_e * exposure_s / TOLD_S)
        shots.append(GAIN_DN_PER_E * up_e + noise(k))
    found = told(*shots)
    assert found is not None
    assert found.exact
    assert found.hints["of_dark_current"] == of_dark
    true = {"fraction": fraction, "amplitude_e": amplitude_e,
            "dwell_up_s": up_s, "dwell_down_s": down_s}  # fmt: skip
    spread = {"exponential": 1.0, "alike": 0.0}.get(law)
    if spread is not None:
        assert found.hints["spread"] == pytest.approx(spread, abs=4 * found.errors["spread"])
    for name, value in true.items():
        assert found.hints[name] == pytest.approx(value, abs=4 * found.errors[name]), name
        assert found.errors[name] < within * value


def test_noise_of_other_kinds_is_no_chain() -> None:
    """Normal noise that is ten times as wide in some pixels has no two levels; flashes have two and
    stay for a frame; a hot pixel has one."""
    rng = np.random.default_rng(5)
    some = rng.uniform(size=(HEIGHT, WIDTH)) < 0.01
    wide = np.where(some, 10.0, 1.0) * noise(6)
    assert told(wide, wide) is None
    flashes = 40.0 * (some & (rng.uniform(size=(FRAMES, HEIGHT, WIDTH)) < 0.2))
    assert told(noise(7) + flashes, noise(8) + flashes) is None
    assert told(noise(9) + 40.0 * some, noise(10) + 40.0 * some) is None


def test_pixels_that_all_do_the_same_tell_no_chance() -> None:
    """Without noise thirty pixels jump in the same frames, as in no body: their figures have no
    covariance, and there is nothing to count errors by."""
    together = np.zeros((FRAMES, HEIGHT, WIDTH))
    together[10:20, 50:55, 60:66] = 20.0
    assert told(together, together) is None
