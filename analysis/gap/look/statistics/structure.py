"""Structure of the noise in time: rows, columns, whole frames, neighbours, frame to frame.

Every figure is a covariance over the variance of a pixel. Independent noise gives 0, or what the
mean over a finite group takes off, which real and simulated frames share.
"""

from __future__ import annotations

import cv2
import numpy as np

from analysis.gap.look.statistics.group import Group, lagged, safe_ratio

LAGS = ((0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0), (0, 3))
"""Rows down and columns right, in samples of the lattice."""


def rows(group: Group) -> dict[str, float]:
    """Covariance between pixels of a row, and of rows with later rows: row noise, drift, clamp."""
    return _lines(group.noise.mean(axis=2), group, "row")


def columns(group: Group) -> dict[str, float]:
    """Covariance between pixels of a column in one frame: noise that changes by column."""
    return _lines(group.noise.mean(axis=1), group, "column")


def _lines(lines: np.ndarray, group: Group, kind: str) -> dict[str, float]:
    n, count = lines.shape
    other = group.noise.shape[1] * group.noise.shape[2] // count
    whole = lines.mean(axis=1, keepdims=True)
    lines = lines - whole
    spread = float(np.square(lines).mean()) * n / (n - 1) - group.variance / other
    scale = group.variance
    found = {f"{kind} correlation": safe_ratio(spread, scale)}
    for lag in (1, 2, 8):
        if count > 4 * lag:
            product = float((lines[:, lag:] * lines[:, :-lag]).mean())
            found[f"{kind} correlation, lag {lag}"] = safe_ratio(product, scale)
    return found


def frames(group: Group) -> dict[str, float]:
    """Whole frames that go up and down together, how far they wander, and how the next one follows.

    Over what independent pixels would do, so that any number of them and any noise give figures of
    one size: a mean of squares over its expectation, whose cube root is all but normal (Wilson and
    Hilferty, PNAS 17, 684 (1931)), and 1 of independent noise.
    """
    pixels = group.mean.size
    level = np.array([cv2.sumElems(one)[0] for one in group.codes]) / np.sqrt(pixels)
    steps = np.diff(level)
    by_steps = float(np.square(steps).mean()) / 2
    spread = float(np.cbrt(safe_ratio(by_steps, group.variance)))
    slope = float(np.polyfit(np.arange(len(level)), level, 1)[0])
    found = {
        "frame spread": spread,
        "frame wander": float(np.cbrt(safe_ratio(level.var(ddof=1), group.variance))) - spread,
        "frame trend": safe_ratio(slope, float(np.sqrt(group.variance))),
    }
    if len(level) >= 4:
        following = float((steps[1:] * steps[:-1]).mean())
        found["frame steps, next"] = safe_ratio(following, 2 * by_steps)
    return found


def neighbours(group: Group) -> dict[str, float]:
    """Correlation of the noise with that of samples nearby."""
    n, _, w = group.noise.shape
    scale = group.variance * (n - 1) / n
    return {
        f"neighbour correlation {dy},{dx}": safe_ratio(lagged(group.noise, dy * w + dx), scale)
        for dy, dx in LAGS
    }


def time(group: Group) -> dict[str, float]:
    """Correlation of a pixel with itself in later frames."""
    noise, n = group.noise, len(group.noise)
    size = group.mean.size
    power = np.einsum("nhw,nhw->n", noise, noise) / size
    scale = group.variance
    found = {}
    for lag in (1, 2, 3):
        if n <= lag:
            continue
        together = np.einsum("nhw,nhw->n", noise[lag:], noise[:-lag]) / size
        steps = (power[lag:] + power[:-lag]) / 2 - together
        found[f"time structure, lag {lag}"] = safe_ratio(float(steps.mean()), scale) - 1.0
    return found


def tails(group: Group) -> dict[str, float]:
    """Skewness and kurtosis of the noise, and pixels that are far noisier than most."""
    noise, n = group.noise, len(group.noise)
    square = np.square(noise)
    flat, flat_square = noise.ravel(), square.ravel()
    by_pixel = group.energy / n
    v = float(by_pixel.mean(dtype=np.float64))
    third = float(np.dot(flat_square, flat)) / flat.size
    fourth = float(np.dot(flat_square, flat_square)) / flat.size
    loud = float((by_pixel > 5 * v).mean()) if v > 0 else 0.0
    return {
        "skewness": safe_ratio(third, v**1.5),
        "kurtosis": safe_ratio(fourth, v * v) - 3.0,
        "loud pixels": float(np.sqrt(loud)),
        "spread of pixel variance": safe_ratio(float(by_pixel.std()), v),
    }
