"""Every statistic of one group of frames, and its mean images block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.families import FAMILIES, GREENS, INTERPOLATION, NEIGHBOURS
from analysis.gap.look.lattices import channels_of, inner, of_a_mosaic
from analysis.gap.look.observation import View
from analysis.gap.look.statistics.greens import greens
from analysis.gap.look.statistics.group import Figures, Group
from analysis.gap.look.statistics.interpolation import interpolation
from analysis.gap.look.statistics.next_door import next_door

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class OfAGroup:
    """Figures of one group by family, lattice and statistic; mean images and noise of channels."""

    figures: dict[tuple[str, str, str], float]
    means: Floats
    noise: Floats
    grid: tuple[int, int]


def on_lattices(groups: Sequence[NDArray[Any]], lit: bool, view: View) -> list[OfAGroup]:
    """Every family on every lattice; images of lattices of one channel are averaged."""
    lattices, channels = view.lattices, [lattice.channel for lattice in view.lattices]
    codes = np.array([lattice.of(dn) for dn in groups for lattice in lattices])
    group = Group(codes=codes, top_dn=view.top_dn, lit=lit)
    names, columns = [], []
    for family, (function, _) in FAMILIES.items():
        for statistic, values in function(group).items():
            names.append((family, statistic))
            columns.append(values)
    figures = np.array(columns).T.reshape(len(groups), len(lattices), -1).tolist()
    images = blocks(group.mean, view.side)
    grid = images.shape[1], images.shape[2]
    images = images.reshape(len(groups), len(lattices), -1)
    # noise of the blocks alone: what is left out of them may be darker than they are
    energy = group.energy[:, : grid[0] * view.side, : grid[1] * view.side]
    variance = energy.mean(axis=(1, 2), dtype=np.float64) / (group.frames - 1)
    variance = variance.reshape(len(groups), len(lattices))
    noise = group.noise.reshape(len(groups), len(lattices), *group.noise.shape[1:])
    mosaic = of_a_mosaic(lattices)
    places = [np.array(channels) == one for one in channels_of(lattices)]
    return [
        OfAGroup(
            figures={
                (family, lattice.name, statistic): value
                for lattice, values in zip(lattices, figures[k], strict=True)
                for (family, statistic), value in zip(names, values, strict=True)
            }
            | _whole(NEIGHBOURS, next_door(noise[k], variance[k]) if mosaic else {})
            | _whole(GREENS, greens(images[k], lattices) if lit else {}),
            means=np.array([images[k, own].mean(axis=0) for own in places]),
            noise=np.array([variance[k, own].mean() for own in places]),
            grid=grid,
        )
        for k in range(len(groups))
    ]


def between(dn: NDArray[Any], view: View) -> dict[tuple[str, str, str], float]:
    """Figures of interpolated samples against measured ones, (n, H, W[, 3])."""
    return _whole(INTERPOLATION, interpolation(inner(dn), view.lattices))


def _whole(family: str, found: Figures) -> dict[tuple[str, str, str], float]:
    """Figures that belong to no lattice by itself."""
    return {(family, "all", name): float(value) for name, value in found.items()}


def blocks(image: NDArray[Any], side: int) -> Floats:
    """Means over square blocks; what does not fill one is left out."""
    h, w = (n // side * side for n in image.shape[-2:])
    rows = image[..., :h, :w].reshape(*image.shape[:-2], h // side, side, w)
    sums = rows.sum(axis=-2, dtype=np.float64).reshape(*rows.shape[:-2], w // side, side)
    return np.asarray(sums.sum(axis=-1) / side**2)
