"""What a change does, as far as twins with different random numbers agree on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.kinds import kinds
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]


def agreed(before: Sequence[Observation], after: Sequence[Observation]) -> tuple[Floats, Floats]:
    """What a change does to figures and block means, as far as all random numbers agree on it.

    Differences of twins with the same random numbers still have noise, from rounding above all, and
    a thousand small errors of a direction are as bad as one large error: they would make it longer,
    and whatever is measured along it too small. The mean m of a figure with standard error e is
    drawn to zero by 1 - (e / m)^2, and once more by what all figures of one kind together have of
    that ratio: a kind of figure that does not move says so by its many members.

    Args:
        before, after: twins without and with the change, one for each set of random numbers.

    Returns:
        changes of the mean over groups: of figures in their own units, (keys,), and of block means
        in DN, (shots, channels, blocks).
    """
    pairs = list(zip(before, after, strict=True))
    figures = np.array([(b.figures - a.figures).mean(axis=0) for a, b in pairs])
    means = np.array([(b.means - a.means).mean(axis=0) for a, b in pairs])
    return agreed_of(figures, means, before[0])


def agreed_of(figures: Floats, means: Floats, seen: Observation) -> tuple[Floats, Floats]:
    """What a change does, as far as all random numbers agree on it, from what it does by each.

    See `agreed` for how the noise of these differences is drawn to zero.

    Args:
        figures: changes of the figures, each in its own unit, (sets, keys).
        means: changes of the block means in DN, (sets, shots, channels, blocks).
        seen: one of those that changed, with the same figures: their kinds, and its picture.

    Returns:
        changes of figures, (keys,), and of block means in DN, (shots, channels, blocks).
    """
    if len(figures) == 1:
        return figures[0], means[0]
    mean, square = figures.mean(axis=0), figures.var(axis=0, ddof=1) / len(figures)
    drawn = np.zeros_like(mean)
    for places in kinds(seen.keys, seen.lit):
        own, noise = mean[places], square[places]
        noise = (noise + BORROWED * noise.mean()) / (1 + BORROWED)
        drawn[places] = _to_zero(own, noise)
    return drawn, _coherent(means, seen.means[0])


BORROWED = 3.0
"""Weight of the others of its kind in the noise of a figure's change, against its own."""


def _coherent(images: Floats, picture: Floats) -> Floats:
    """What several images of one thing have in common.

    An image is a constant, a multiple of the picture, and a rest. Of most changes the first two are
    all, and as certain as so many blocks make them, while the rest is noise as long as itself. Each
    part is drawn to zero as figures are, so that amounts along the whole are right.

    Args:
        images: changes of block means, (sets, shots, channels, blocks).
        picture: the block means that changed, (shots, channels, blocks).
    """
    sets, blocks = len(images), images.shape[-1]
    flat = picture - picture.mean(axis=-1, keepdims=True)
    size = np.linalg.norm(flat, axis=-1, keepdims=True)
    unit = np.divide(flat, size, out=np.zeros_like(flat), where=size > 0)
    constant = images.mean(axis=-1, keepdims=True)
    along = (images * unit).sum(axis=-1, keepdims=True)
    rest = images - constant - along * unit
    # of one block in the mean of all sets
    noise = rest.var(axis=0, ddof=1).mean(axis=-1, keepdims=True) / sets

    def drawn(parts: Floats, expected: Floats) -> Floats:
        own = parts.var(axis=0, ddof=1) / sets
        return _to_zero(parts.mean(axis=0), (own + BORROWED * expected) / (1 + BORROWED))

    both = drawn(constant, noise / blocks) + drawn(along, noise) * unit
    return np.asarray(both + _shapes(rest, noise))


def _shapes(images: Floats, noise: Floats) -> Floats:
    """The mean of images less its noise: what is left of them has few shapes in all shots.

    More vignetting takes the same part of every shot and colour, so that all that changes is one
    shape, and the noise of each block is averaged over shots and colours. In units of the noise the
    mean is a matrix of shapes whose singular values are shrunk as is best for them in white noise:
    of R rows and B blocks, with y = s / sqrt(B) and b = R / B,

        s -> sqrt((y^2 - b - 1)^2 - 4 b) sqrt(B) / y        0 for y < 1 + sqrt(b)

    A pattern that belongs to a camera body is one shape in all shots as well, but another one in
    every body: of each shape that part is kept which two sets have in common, by the product of
    theirs over the square of the mean less its noise. Nothing of such a pattern is left, though
    figures of its size are.

    Reference: Gavish and Donoho, "Optimal shrinkage of singular values", IEEE Trans. Inf. Theory
    63, 2137 (2017), for the squared error.

    Args:
        images: (sets, shots, channels, blocks).
        noise: variance of a block in the mean of all sets, (shots, channels, 1).
    """
    sets, blocks = len(images), images.shape[-1]
    moved = noise.ravel() > 0
    size = np.sqrt(noise.reshape(-1, 1)[moved])
    rows = images.reshape(sets, -1, blocks)
    mean = rows.mean(axis=0)
    u, s, v = np.linalg.svd(mean[moved] / size, full_matrices=False)
    square, ratio = np.square(s) / blocks, len(size) / blocks
    beyond = np.square(np.maximum(square - ratio - 1.0, 0.0)) - 4.0 * ratio
    shrunk = np.sqrt(np.maximum(beyond, 0.0) / np.maximum(square, 1e-300) * blocks)
    of_sets = u.T @ (rows[:, moved] / size)
    alone = np.square(of_sets).sum(axis=(0, 2))
    in_common = (np.square(of_sets.sum(axis=0)).sum(axis=1) - alone) / (sets * (sets - 1))
    shrunk *= np.maximum(in_common, 0.0) / np.maximum(np.square(s) - blocks, 1e-300)
    mean[moved] = (u * shrunk) @ v * size
    return np.asarray(mean.reshape(images.shape[1:]))


def _to_zero(means: Floats, squares: Floats) -> Floats:
    """Figures of one kind less the part of them that errors of such squares would have."""
    ratio = np.square(means) / np.maximum(squares, 1e-300)
    return np.asarray(means * _beyond(ratio, 1.0) * _beyond(ratio.mean(), 1.0))


def _beyond(found: Floats, expected: Floats | float) -> Floats:
    """Part of squares that is more than noise."""
    return np.maximum(0.0, 1.0 - expected / np.maximum(found, 1e-300))
