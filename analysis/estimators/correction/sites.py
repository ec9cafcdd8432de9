"""Native sites of a demosaiced image: where a pixel still holds what the sensor measured.

A bilinear demosaic passes measured samples unchanged and fills the rest with means of 2 or 4, so
at measured sites noise has its full variance, and no two of them share a sample. Everything that
the corrected estimator reads, it reads there: no attenuation factor is needed, and neighbours are
independent.

Where nobody stated the phase of the mosaic, the noise shows it. In each channel the variance at
the four sites of a 2 x 2 cell relative to the measured one is

    R, B:  1 at its own site, 1/2 beside and below it, 1/4 diagonally
    G:     1 at its two sites, 1/4 at the other two

and 1 everywhere where nothing was interpolated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.panel_noise import Floats
from sensor.frames import MOSAICS, Capture, Frames, Panel

EVERY_PIXEL = "none"
"""The mosaic of a camera that measures all colours in every pixel."""

CLOSE = 0.15
"""RMS difference in ln variance up to which the demosaic passes for a bilinear one: rounding of
noise of half a step changes a variance by as much."""

CLEAR = 0.3
"""By how much in RMS ln variance a phase must fit better than the next to be recognised."""

LOUD_DN2 = 0.5
"""Temporal variance from which a panel takes part in recognition: rounding then hardly matters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Lattice:
    """Native sites of one colour in a panel.

    Attributes:
        panel: its name.
        phase: offset (row, column) of the first site in the 2 x 2 cell of the image.
        stacks: samples (N, h, w) by label of the shot.
        shape: (h, w).
        row, column: place of each site in pixels of the panel, flat (h w,).
    """

    panel: str
    phase: tuple[int, int]
    stacks: Mapping[str, NDArray[Any]]
    shape: tuple[int, int]
    row: Floats
    column: Floats


@dataclass(frozen=True, kw_only=True)
class Mosaic:
    """What is known of the colour mosaic behind demosaiced frames.

    Attributes:
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1), `EVERY_PIXEL`, or None where the
            frames do not show it.
        stated: whether the capture said so.
        misfit: RMS difference in ln variance from a bilinear demosaic of that phase; None where
            the noise is too quiet to see it.
    """

    cfa: str | None
    stated: bool
    misfit: float | None


def mosaic_of(capture: Capture) -> Mosaic:
    """The mosaic of a demosaiced capture: stated, or recognised from the noise of its panels."""
    stated = capture.frames[0].cfa
    found = _variance_by_phase(capture)
    if found is None:
        return Mosaic(cfa=stated, stated=stated is not None, misfit=None)
    misfit = {cfa: _misfit(found, cfa) for cfa in (*MOSAICS, EVERY_PIXEL)}
    if stated is not None:
        return Mosaic(cfa=stated, stated=True, misfit=misfit.get(stated))
    best, second = sorted(misfit, key=lambda cfa: misfit[cfa])[:2]
    clear = misfit[second] - misfit[best] > CLEAR
    return Mosaic(cfa=best if clear else None, stated=False, misfit=misfit[best])


def lattices(capture: Capture, panel: Panel, channel: str, cfa: str | None) -> tuple[Lattice, ...]:
    """The native sites of a channel in a panel, each regular lattice for itself.

    Where `cfa` is None or `EVERY_PIXEL`, every pixel of a demosaiced image is taken.
    """
    if capture.frames[0].demosaiced:
        phases = [(k // 2, k % 2) for k in range(4) if cfa in MOSAICS and cfa[k] == channel]
    elif channel == "Y":
        phases = []
    else:
        own = capture.frames[0].cfa or ""
        phases = [(k // 2, k % 2) for k in range(4) if own[k] == channel]
    step = 2 if phases else 1
    found = []
    for i, j in phases or [(0, 0)]:
        first_row, first_column = (i - panel.y) % step, (j - panel.x) % step
        rows = np.arange(first_row, panel.h, step, dtype=np.float64)
        columns = np.arange(first_column, panel.w, step, dtype=np.float64)
        row, column = (a.ravel() for a in np.meshgrid(rows, columns, indexing="ij"))
        stacks = {
            frames.shot.label: _plane(frames, panel, channel)[
                :, first_row::step, first_column::step
            ]
            for frames in capture.frames
        }
        found.append(
            Lattice(
                panel=panel.name,
                phase=(i, j),
                stacks=stacks,
                shape=(rows.size, columns.size),
                row=row,
                column=column,
            )
        )
    return tuple(found)


def _plane(frames: Frames, panel: Panel, channel: str) -> NDArray[Any]:
    rows, columns = panel.window
    if frames.demosaiced:
        return frames.dn[:, rows, columns, "RGB".index(channel)]
    return frames.dn[:, rows, columns]


def _variance_by_phase(capture: Capture) -> Floats | None:
    """Mean ln of the temporal variance by channel and site of the 2 x 2 cell, (3, 2, 2).

    Each panel's own mean over the cell is taken off, so that panels of all levels add up. None
    where no panel of any shot is loud enough in every channel, and clear of both ends.
    """
    gathered = []
    for frames in capture.frames:
        for panel in capture.areas:
            rows, columns = panel.window
            dn = np.asarray(frames.dn[:, rows, columns])
            if dn.min() == 0 or dn.max() >= frames.top_dn:
                continue
            variance = dn.var(axis=0, ddof=1, dtype=np.float32)
            cell = np.array(
                [
                    [
                        variance[(i - panel.y) % 2 :: 2, (j - panel.x) % 2 :: 2].mean(axis=(0, 1))
                        for j in (0, 1)
                    ]
                    for i in (0, 1)
                ]
            )
            cell = np.moveaxis(cell, 2, 0).astype(np.float64) - 1 / 12
            if cell.min() > LOUD_DN2 / 4 and cell.max(axis=(1, 2)).min() > LOUD_DN2:
                relative = np.log(cell)
                gathered.append(relative - relative.mean(axis=(1, 2), keepdims=True))
    return np.mean(gathered, axis=0) if gathered else None


def _misfit(found: Floats, cfa: str) -> float:
    expected = np.log([_bilinear(cfa, colour) for colour in "RGB"])
    expected -= expected.mean(axis=(1, 2), keepdims=True)
    return float(np.sqrt(np.mean((found - expected) ** 2)))


def _bilinear(cfa: str, colour: str) -> Floats:
    """Variance of a colour after a bilinear demosaic by site of the 2 x 2 cell."""
    if cfa == EVERY_PIXEL:
        return np.ones((2, 2))
    own = np.array([c == colour for c in cfa], dtype=np.float64).reshape(2, 2)
    if colour == "G":
        return np.where(own > 0, 1.0, 0.25)
    i, j = np.argwhere(own)[0]
    cell = np.full((2, 2), 0.5)
    cell[i, j], cell[1 - i, 1 - j] = 1.0, 0.25
    return cell
