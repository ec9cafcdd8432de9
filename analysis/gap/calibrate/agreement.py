"""What a change does, as far as twins with different random numbers agree on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.kinds import kinds
from analysis.gap.look.observe import Key, Observation

Floats = NDArray[np.float64]

COHERENT = 0.2
"""Correlation from which two images show the same thing."""


def agreed(before: Sequence[Observation], after: Sequence[Observation]) -> tuple[Floats, Floats]:
    """What a change does to figures and block means, as far as all random numbers agree on it.

    Differences of twins with the same random numbers still have noise, from rounding above all, and
    a thousand small errors of a direction are as bad as one large error: they would make it longer,
    and whatever is measured along it too small. The mean m of a figure with standard error e is
    drawn to zero by 1 - (e / m)^2, and once more by what all figures of one kind together have of
    that ratio: a kind of figure that does not move says so by its many members.
    """
    pairs = list(zip(before, after, strict=True))
    figures = np.array([(b.figures - a.figures).mean(axis=0) for a, b in pairs])
    means = np.array([(b.means - a.means).mean(axis=0) for a, b in pairs])
    return agreed_of(figures, means, before[0].keys, before[0].lit)


def agreed_of(
    figures: Floats, means: Floats, keys: tuple[Key, ...], lit: frozenset[str]
) -> tuple[Floats, Floats]:
    """The same of differences that were taken before.

    Args:
        figures, means: differences, a row for each set of random numbers.
        keys: of the figures.
        lit: labels of the shots with a lamp on.
    """
    if len(figures) == 1:
        return figures[0], means[0]
    mean, square = figures.mean(axis=0), figures.var(axis=0, ddof=1) / len(figures)
    drawn = np.zeros_like(mean)
    for places in kinds(keys, lit):
        own, noise = mean[places], square[places]
        noise = (noise + BORROWED * noise.mean()) / (1 + BORROWED)
        ratio = np.square(own) / np.maximum(noise, 1e-300)
        of_kind = max(0.0, 1.0 - 1.0 / max(float(ratio.mean()), 1e-300))
        drawn[places] = own * of_kind * np.maximum(0.0, 1.0 - 1.0 / np.maximum(ratio, 1e-300))
    return drawn, _coherent(means)


BORROWED = 3.0
"""Weight of the others of its kind in the noise of a figure's change, against its own."""


def _coherent(images: Floats) -> Floats:
    """Mean of images that show the same thing; nothing, where each shows another.

    A pattern that belongs to a camera body is in another place in every body: no template of the
    mean image, though figures of its size are.
    """
    mean = images.mean(axis=0)
    total = float(np.square(images).sum())
    if len(images) == 1 or total == 0:
        return np.asarray(mean)
    alike = (len(images) * float(np.square(mean).sum()) - total / len(images)) / total
    return np.asarray(mean) if alike > COHERENT * (1 - 1 / len(images)) else np.zeros_like(mean)
