"""How far blocks of a model's twins scatter beyond what noise, fixed pattern and light make.

Dust, hot pixels and whatever else has another pattern in each body does so. Of a pattern that adds
to the signal m of a block in the shots s and t, or takes a part of it, the mean over twins is

    E[d_s d_t] - C_st = A_st + B_st m_s m_t

so that A and B are a regression over all blocks of a channel. A model whose C knew nothing of it
would call every body but its own unlike it, and the least of the effect would fit best.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.ruler import ruler
from analysis.gap.calibrate.shared import Shared, shared
from analysis.gap.calibrate.space import Space
from analysis.gap.camera.base import Base
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]

TERMS = 2
"""Of the covariance of a block between shots: an offset, and a part of the signals."""

WEIGHED = 2
"""Times the terms are fitted: the second time by errors that have the pattern in them."""


def fair(count: int) -> float:
    """What the difference of one of so many from their mean lacks, against that of another."""
    return float(np.sqrt((count + 1) / (count - 1)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Beyond:
    """What blocks of twins have beyond their space.

    Attributes:
        own: covariance of each by itself, (channels, blocks, shots, shots).
        shared: what blocks of a shot have in common, where they do.
    """

    own: Floats
    shared: Shared | None = None

    def only(self, shots: list[int]) -> Beyond:
        """What blocks have beyond their space in some of the shots, by their places."""
        few = self.shared.only(shots) if self.shared else None
        return Beyond(own=self.own[..., shots, :][..., shots], shared=few)


def beyond(of_one: Space, base: Base, bodies: Observation, *, in_common: bool = True) -> Beyond:
    """What blocks of twins have beyond their space.

    Independent noise alone of S shots in n blocks has eigenvalues up to Marchenko and Pastur's
    edge, (1 + sqrt(S / n))^2 of its variance: so much is chance, for each of two terms.

    Args:
        of_one: of one group of frames of a camera.
        base: the camera.
        bodies: twins of it.
        in_common: whether what blocks of a shot have in common is told apart.
    """
    shots, _, blocks = of_one.shape
    signal = _signal(base, bodies)
    root = np.linalg.inv(of_one.whitening)
    known = root @ root.transpose(0, 1, 3, 2)
    found_shared, rest = None, fair(bodies.groups) * (bodies.means - of_one.expected_means)
    if in_common:
        found_shared, rest = shared(ruler(known, base, bodies, signal), rest)
    off = rest.transpose(2, 3, 0, 1)
    more = off.transpose(0, 1, 3, 2) @ off / bodies.groups - known
    product = signal[..., :, None] * signal[..., None, :]
    chance = (1.0 + np.sqrt(TERMS * shots / ((bodies.groups - 1) * blocks))) ** 2 - 1.0
    found = np.zeros_like(known)
    for _ in range(WEIGHED):
        fitted = _additive_and_part(more, product, known + found)
        values, vectors = np.linalg.eigh(
            of_one.whitening @ fitted @ of_one.whitening.transpose(0, 1, 3, 2)
        )
        size = np.sqrt(np.maximum(values - chance, 0.0))
        factor = root @ (vectors * size[..., None, :])
        found = factor @ factor.transpose(0, 1, 3, 2)
    return Beyond(own=np.asarray(found), shared=found_shared)


def _signal(base: Base, bodies: Observation) -> Floats:
    """Of blocks above black, (channels, blocks, shots): the typical twin's.

    A hot photosite in one twin must not make its block a brighter one than others, where the next
    body has its own. In the dark nothing else tells blocks from each other.
    """
    above = np.median(bodies.means, axis=0) - base.black_dn[:, None]
    dark = [shot not in bodies.lit for shot in bodies.shots]
    above[dark] = np.median(above[dark], axis=-1, keepdims=True)
    return np.asarray(np.maximum(above, 0.0).transpose(1, 2, 0))


def _additive_and_part(more: Floats, product: Floats, known: Floats) -> Floats:
    """The two terms of a covariance that fit best, in each block: (channels, blocks, S, S).

    Args:
        more: what blocks have.
        product: of the signals of two shots.
        known: covariance by which products of two differences scatter.
    """
    own = np.diagonal(known, axis1=-2, axis2=-1)
    weight = 1.0 / (own[..., :, None] * own[..., None, :] + np.square(known))
    scale = np.maximum(product.mean(axis=1, keepdims=True), 1e-12)
    terms = np.stack([np.ones_like(product), product / scale])
    normal = np.einsum("ukbst,vkbst,kbst->kstuv", terms, terms, weight)
    right = np.einsum("ukbst,kbst,kbst->kstu", terms, more, weight)
    found = np.linalg.pinv(normal, rcond=1e-9, hermitian=True) @ right[..., None]
    return np.asarray(np.einsum("ukbst,kstu->kbst", terms, found[..., 0]))


def widened(
    space: Space, by: Beyond, bodies: Observation, seen: Observation | None = None
) -> Space:
    """A space whose blocks are as uncertain as twins show them.

    Args:
        space: by noise, fixed pattern and light.
        by: what blocks of the twins have beyond it.
        bodies: the twins.
        seen: the capture that it is for, whose groups of frames are averaged; one group by default.
    """
    root = np.linalg.inv(space.whitening)
    covariance = root @ root.transpose(0, 1, 3, 2) + by.own
    wide = dataclasses.replace(space, whitening=np.linalg.inv(np.linalg.cholesky(covariance)))
    if by.shared is None:
        return wide
    in_common = by.shared
    if seen is not None:
        in_common = in_common.averaged(seen.means - space.expected_means)
    return in_common.taken_off(wide, bodies.groups)
