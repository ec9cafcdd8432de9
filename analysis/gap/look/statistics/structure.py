"""Structure of the noise in time: rows, columns, whole frames, neighbours, frame to frame.

Every figure is a covariance over the variance of a pixel. Independent noise gives 0, or what the
mean over a finite group takes off, which real and simulated frames share.
"""

from __future__ import annotations

import numpy as np

from analysis.gap.look.statistics.group import Array, Figures, Floats, Group, lagged, safe_ratio

LAGS = ((0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0), (0, 3))
"""Rows down and columns right, in samples of the lattice."""

FRAME_SPREAD = "frame spread"


def rows(group: Group) -> Figures:
    """Covariance between pixels of a row, and of rows with later rows: row noise, drift, clamp."""
    return _lines(group.rows, group, "row")


def columns(group: Group) -> Figures:
    """Covariance between pixels of a column in one frame: noise that changes by column."""
    return _lines(group.columns, group, "column")


def _lines(lines: Floats, group: Group, kind: str) -> Figures:
    count, n, scale = lines.shape[2], group.frames, group.variance
    lines = lines - lines.mean(axis=2, keepdims=True)
    spread = np.square(lines).mean(axis=(1, 2)) * n / (n - 1) - scale * count / group.pixels
    found = {f"{kind} correlation": safe_ratio(spread, scale)}
    for lag in (1, 2, 8):
        if count > 4 * lag:
            product = (lines[..., lag:] * lines[..., :-lag]).mean(axis=(1, 2))
            found[f"{kind} correlation, lag {lag}"] = safe_ratio(product, scale)
    return found


def frames(group: Group) -> Figures:
    """Whole frames that go up and down together, how far they wander, and how the next one follows.

    Over what independent pixels would do, so that any number of them and any noise give figures of
    one size: a mean of squares over its expectation, whose cube root is all but normal (Wilson and
    Hilferty, PNAS 17, 684 (1931)), and 1 of independent noise.
    """
    level = group.rows.mean(axis=2) * np.sqrt(group.pixels)
    steps = np.diff(level)
    by_steps = np.square(steps).mean(axis=1) / 2
    spread = np.cbrt(safe_ratio(by_steps, group.variance))
    wander = np.cbrt(safe_ratio(level.var(axis=1, ddof=1), group.variance))
    middle = (group.frames - 1) / 2
    when = np.arange(group.frames) - middle
    slope = level @ when / (when @ when)
    found = {
        FRAME_SPREAD: spread,
        "frame wander": wander - spread,
        "frame trend": safe_ratio(slope, np.sqrt(group.variance)),
    }
    if group.frames >= 4:
        following = (steps[:, 1:] * steps[:, :-1]).mean(axis=1)
        found["frame steps, next"] = safe_ratio(following, 2 * by_steps)
    return found


def neighbours(group: Group) -> Figures:
    """Correlation of the noise with that of samples nearby."""
    n, w = group.frames, group.noise.shape[3]
    scale = group.variance * (n - 1) / n
    flat = group.noise.reshape(len(group.codes), -1)
    return {
        f"neighbour correlation {dy},{dx}": safe_ratio(lagged(flat, dy * w + dx), scale)
        for dy, dx in LAGS
    }


def time(group: Group) -> Figures:
    """Correlation of a pixel with itself in later frames."""
    n = group.frames
    power = np.diagonal(group.products, axis1=1, axis2=2)
    found = {}
    for lag in (1, 2, 3):
        if n <= lag:
            continue
        together = np.diagonal(group.products, lag, axis1=1, axis2=2)
        steps = (power[:, lag:] + power[:, :-lag]) / 2 - together
        found[f"time structure, lag {lag}"] = safe_ratio(steps.mean(axis=1), group.variance) - 1.0
    return found


def tails(group: Group) -> Figures:
    """Skewness and kurtosis of the noise, and pixels that are far noisier than most.

    A pixel that jumps between two levels is noisy in even frames and in odd ones; a noise with
    heavy tails is another pixel's in each frame. Both have the same kurtosis; the correlation over
    pixels of what even and odd frames say of them tells the one from the other. A handful of very
    loud pixels makes that another one in every body: of them darks tell how many are loud in even
    frames and in odd ones.
    """
    n, k = group.frames, len(group.codes)
    flat, square = group.noise.reshape(k, -1), group.square.reshape(k, -1)
    by_pixel = group.energy.reshape(k, -1) / np.float32(n)
    v = group.variance * (n - 1) / n
    third, fourth = np.vecdot(square, flat), np.vecdot(square, square)
    loud = (by_pixel > 5 * v[:, None]).mean(axis=1)
    found = {
        "skewness": safe_ratio(third / flat.shape[1], v**1.5),
        "kurtosis": safe_ratio(fourth / flat.shape[1], v * v) - 3.0,
        "loud pixels": np.where(v > 0, np.sqrt(loud), 0.0),
        "spread of pixel variance": safe_ratio(by_pixel.std(axis=1), v),
        "pixel variance that stays": _correlation(*group.energy_of_halves),
    }
    if not group.lit:
        found["loud pixels that stay"] = _in_both(*group.energy_of_halves, LOUD * v * n / 2)
    return found


LOUD = 8.0
"""Times the mean variance from which a pixel is loud by half of a group's frames. Of four
frames of a group of eight chi-squared of 3 is then over 28, as of one normal pixel in 275,000."""

FEW = 5.0
"""Loud pixels below which those that stay are a small part, whatever they are of these."""


def _in_both(a: Array, b: Array, least: Floats) -> Floats:
    """Part of the pixels above some energy in either of two images (k, h, w) that are in both."""
    first, second = (one > least[:, None, None] for one in (a, b))
    either = (first.sum(axis=(1, 2)) + second.sum(axis=(1, 2))) / 2
    return np.asarray((first & second).sum(axis=(1, 2)) / (either + FEW))


def _correlation(a: Array, b: Array) -> Floats:
    """Of two images (k, h, w) over their pixels, (k,)."""
    a, b = (one.reshape(len(one), -1) for one in (a, b))
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    return safe_ratio(np.vecdot(a, b), np.sqrt(np.vecdot(a, a) * np.vecdot(b, b)))
