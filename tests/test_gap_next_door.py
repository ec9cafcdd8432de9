"""Noise of photosites next door to each other tells charge that goes from one into the other."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.look.statistics.next_door import next_door

FRAMES, HEIGHT, WIDTH = 8, 96, 128
LEVELS = (900.0, 2500.0, 2500.0, 400.0)
PAIRS = FRAMES * HEIGHT * WIDTH
ERROR = 1.0 / np.sqrt(PAIRS)


def counts(seed: int) -> np.ndarray:
    """Electrons of a mosaic, (n, H, W)."""
    mean = np.empty((HEIGHT, WIDTH))
    for site, level in enumerate(LEVELS):
        mean[site // 2 :: 2, site % 2 :: 2] = level
    return np.random.default_rng(seed).poisson(mean, (FRAMES, HEIGHT, WIDTH)).astype(float)


def figures(frames: np.ndarray) -> dict[str, float]:
    """What is seen of these frames."""
    noise = frames - frames.mean(axis=0)
    sites = np.array([noise[:, y::2, x::2] for y in (0, 1) for x in (0, 1)], dtype=np.float32)
    variance = np.square(sites, dtype=np.float64).mean(axis=(1, 2, 3)) * FRAMES / (FRAMES - 1)
    return {name: float(value) for name, value in next_door(sites, variance).items()}


def test_what_was_counted_apart_does_not_agree() -> None:
    """At 4 standard errors for four figures; a growth is a difference of two halves."""
    found = figures(counts(1))
    assert found["next, across"] == pytest.approx(0, abs=4 * ERROR)
    assert found["next, down"] == pytest.approx(0, abs=4 * ERROR)
    assert found["next, across, growing"] == pytest.approx(0, abs=8 * ERROR)
    assert found["next, down, growing"] == pytest.approx(0, abs=8 * ERROR)


@pytest.mark.parametrize("down", [False, True])
def test_charge_that_is_left_behind_agrees_with_what_it_was_left_by(down: bool) -> None:
    """A part of each charge goes into the next one, of another colour, more of it the further it
    has to go, up to p at the end. To the first order, of two sites with the variances a and b the
    correlation is then (p / 2) sqrt(a / b) in the mean, a the one it is taken from; and it grows by
    half of p sqrt(a / b) from the first half to the second."""
    part, electrons = 0.04, counts(2)
    axis = 1 if down else 2
    size = electrons.shape[axis]
    lost = electrons * np.moveaxis(
        np.broadcast_to(
            part * (np.arange(size) + 0.5) / size,
            (FRAMES, *((WIDTH, HEIGHT) if down else (HEIGHT, WIDTH))),
        ),
        2,
        axis,
    )
    after = electrons - lost
    into = [slice(None)] * 3
    out = [slice(None)] * 3
    into[axis], out[axis] = slice(1, None), slice(None, -1)
    after[tuple(into)] += lost[tuple(out)]
    beside = {0: 2, 2: 0, 1: 3, 3: 1} if down else {0: 1, 1: 0, 2: 3, 3: 2}
    ratio = np.mean([np.sqrt(LEVELS[a] / LEVELS[b]) for a, b in beside.items()])
    name, other = ("down", "across") if down else ("across", "down")
    found = figures(after)
    assert found[f"next, {name}"] == pytest.approx(part / 2 * ratio, abs=4 * ERROR + part**2)
    grows = part / 2 * ratio
    assert found[f"next, {name}, growing"] == pytest.approx(grows, abs=8 * ERROR + part**2)
    assert found[f"next, {other}"] == pytest.approx(0, abs=4 * ERROR)
