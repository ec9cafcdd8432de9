"""How far blocks of a model's twins scatter beyond what noise, fixed pattern and light make.

Dust, hot pixels and whatever else has another pattern in each body does so, and in the shots where
it shows:

    C' = C + L (M - edge)+ L'        L L' = C,  M = mean of w w',  w = L^-1 (twin - mean of twins)

with one M per channel for all blocks. A model whose C knew nothing of it would call every body but
its own unlike it, and the least of the effect would fit best. Of S shots in n blocks independent
noise alone has eigenvalues of M up to Marchenko and Pastur's edge, (1 + sqrt(S / n))^2.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.space import Space
from analysis.gap.look.observe import Observation

Floats = NDArray[np.float64]


def fair(count: int) -> float:
    """What the difference of one of so many from their mean lacks, against that of another."""
    return float(np.sqrt((count + 1) / (count - 1)))


def beyond(of_one: Space, bodies: Observation) -> Floats:
    """Covariance that blocks of twins have beyond their space, (channels, blocks, shots, shots).

    Args:
        of_one: of one group of frames of a camera.
        bodies: twins of it.
    """
    shots, channels, blocks = of_one.shape
    count = bodies.groups
    off = fair(count) * (bodies.means - of_one.expected_means)
    white = np.einsum("cbst,ktcb->ckbs", of_one.whitening, off).reshape(channels, -1, shots)
    seen = white.transpose(0, 2, 1) @ white / white.shape[1]
    values, vectors = np.linalg.eigh(seen)
    edge = (1.0 + np.sqrt(shots / ((count - 1) * blocks))) ** 2
    excess = (vectors * np.maximum(values - edge, 0.0)[:, None, :]) @ vectors.transpose(0, 2, 1)
    root = np.linalg.inv(of_one.whitening)
    return np.asarray(root @ excess[:, None] @ root.transpose(0, 1, 3, 2))


def widened(space: Space, by: Floats) -> Space:
    """A space whose blocks have a further covariance; see `beyond`."""
    root = np.linalg.inv(space.whitening)
    covariance = root @ root.transpose(0, 1, 3, 2) + by
    return dataclasses.replace(space, whitening=np.linalg.inv(np.linalg.cholesky(covariance)))
