"""The matrix that mixed the colours of a picture, by how the noise of its channels agrees.

A photosite has one filter, so that what three channels show there is one measured sample and two
means of others, whose noise is independent: before a matrix M the covariance of a red site's noise
is a diagonal D_R, that of a blue one's D_B. After it they are

    C_R = M D_R M^T,    C_B = M D_B M^T,    hence    C_R C_B^-1 = M (D_R D_B^-1) M^-1

whatever the noise and the demosaicer, as long as that is linear. The columns of M are eigenvectors;
a bilinear demosaicer makes the eigenvalues 4, 1 and 1/4 times constants of the channels. Rows that
add to 1 say how long each column is. The sites of green have not been used: what their noise still
has in common after M is undone tells whether it was a matrix at all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.lattices import Lattice, inner, of_a_mosaic
from analysis.gap.look.shots import HINT_FRAMES
from analysis.gap.ready.hints import DirectReading
from foundation.cores import in_order
from sensor.colours import Colours
from sensor.effects.color_matrix import ColorMatrix
from sensor.frames import Frames

Floats = NDArray[np.float64]

LEAST_PART = 0.008
"""Of one colour in another, from which a matrix is told."""

CLEAR = 8.0
"""The same in standard errors, by the two halves of the frames' rows."""

MOST_IN_COMMON = 0.25
"""Correlation of two channels at a site of green, with the matrix undone, over the largest part of
one colour in another: less says that it was a matrix. Noise that rows share made as much."""

NOTHING = 0.003
"""Part of one colour in another that is none: no search begins with it."""


def mixed(stacks: Sequence[Frames], lattices: Sequence[Lattice]) -> DirectReading | None:
    """The parts of a matrix; None where noise does not say that there is one.

    Args:
        stacks: frames of the key shots.
        lattices: where each colour was measured.
    """
    if not of_a_mosaic(lattices) or any(stack.dn.ndim != 4 for stack in stacks):
        return None
    halves = covariances(stacks, lattices)
    whole = {name: halves[0][name] + halves[1][name] for name in halves[0]}
    found = [matrix(one) for one in (whole, *halves)]
    if any(one is None for one in found):
        return None
    best, first, second = (one for one in found if one is not None)
    off = np.abs(best - np.diag(np.diag(best)))
    error = np.sqrt(np.square(first - second).sum() / 6) / 2
    most = float(off.max())
    a_matrix = in_common(whole, best) < MOST_IN_COMMON * most
    if most <= max(LEAST_PART, CLEAR * error) or not a_matrix:
        return None
    in_parts = DirectReading(hints=_parts(best), exact=False)
    vivid = _vivid(best)
    if vivid is None:
        return in_parts
    return DirectReading(hints=NO_PARTS | {"saturation": vivid}, exact=False, instead=in_parts)


def covariances(stacks: Sequence[Frames], lattices: Sequence[Lattice]) -> list[dict[str, Floats]]:
    """Of the noise in time of the three channels, by lattice, over all stacks, (3, 3): by every
    other row of each lattice, and by those between.

    Args:
        stacks: colour frames.
        lattices: of a mosaic.
    """
    total = sum(in_order(lambda stack: _of_stack(stack, lattices), stacks), np.zeros(()))
    names = [lattice.name for lattice in lattices]
    return [dict(zip(names, half, strict=True)) for half in total]


def _of_stack(stack: Frames, lattices: Sequence[Lattice]) -> Floats:
    """Of one stack, (2, lattices, 3, 3)."""
    dn = inner(np.asarray(stack.dn[:HINT_FRAMES])).astype(np.float32)
    noise = dn - dn.mean(axis=0)
    noise -= noise.mean(axis=(1, 2), keepdims=True)  # the lamp's and the black level's
    free = 1.0 - 1.0 / len(noise)
    found = np.empty((2, len(lattices), 3, 3))
    for half, k in np.ndindex(found.shape[:2]):
        dy, dx = lattices[k].dy + 2 * half, lattices[k].dx
        sites = noise[:, dy::4, dx::2].reshape(-1, 3)
        found[half, k] = (sites.T @ sites) / (len(sites) * free) - ROUNDING_DN2 * np.eye(3)
    return found


def matrix(by_lattice: dict[str, Floats]) -> Floats | None:
    """M, with rows that add to 1; None where no matrix with a positive diagonal does it.

    Args:
        by_lattice: covariances of the three channels.
    """
    if min(np.linalg.eigvalsh(c).min() for c in by_lattice.values()) <= 0:
        return None
    values, columns = np.linalg.eig(by_lattice["R"] @ np.linalg.inv(by_lattice["B"]))
    if np.any(values.imag):
        return None
    # red has its own noise at a site of red, blue at one of blue
    columns = columns.real[:, np.argsort(-values.real)]
    found = columns * np.linalg.solve(columns, np.ones(3))
    return found if np.diag(found).min() > 0.5 else None


def in_common(by_lattice: dict[str, Floats], mix: Floats) -> float:
    """The largest correlation of two channels at a site of green, with a matrix undone."""
    undo = np.linalg.inv(mix)
    greens = sum(c for name, c in by_lattice.items() if name.startswith("G"))
    left = undo @ greens @ undo.T
    sigma = np.sqrt(np.diag(left))
    return float(np.abs(left / np.outer(sigma, sigma) - np.eye(3)).max())


NO_PARTS: dict[str, float | Colours] = {"next_colour": 0.0, "last_colour": 0.0}
"""Parameters of a matrix that is nothing but a saturation."""

MOSTLY = 0.8
BLURRED = 0.02
"""Part of the squares of a matrix that a saturation has, and what is left of any part of it, from
and up to which it is first of all that: codes that are rounded twice blur six parts by a hundredth,
and one number is likelier than six."""


def _vivid(mix: Floats) -> float | None:
    """The saturation that is nearest to a matrix; None where the matrix is something else."""
    off = ~np.eye(3, dtype=bool)
    one = (ColorMatrix(saturation=2.0).matrix - np.eye(3))[off]
    parts = mix[off]
    amount = float(one @ parts / (one @ one))
    left = parts - amount * one
    mostly = np.square(left).sum() < (1.0 - MOSTLY) * np.square(parts).sum()
    if not mostly or np.abs(left).max() >= BLURRED:
        return None
    return next(p for p in ColorMatrix.parameters() if p.name == "saturation").clipped(1.0 + amount)


def _parts(mix: Floats) -> dict[str, float | Colours]:
    """A matrix as parameters of the effect, inside their ranges; a part that is lost in noise is
    none.
    """
    (most,) = {p.maximum for p in ColorMatrix.parameters() if p.name in NO_PARTS}
    parts = np.where(np.abs(mix) < NOTHING, 0.0, np.clip(mix, -most, most))
    red, green, blue = parts
    return {
        "saturation": 1.0,
        "next_colour": Colours(R=float(red[1]), G=float(green[2]), B=float(blue[0])),
        "last_colour": Colours(R=float(red[2]), G=float(green[0]), B=float(blue[1])),
    }


def matrix_of(told: DirectReading) -> Floats:
    """M, from what was told of it."""
    return ColorMatrix(**told.hints).matrix  # type: ignore[arg-type]
