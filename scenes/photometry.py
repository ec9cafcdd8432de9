"""IES files: the measured angular distribution of a lamp, in the format LM-63.

Photometry of type C: the vertical angle counts from the axis of the lamp, which points down in the
laboratory and at `aim_m` here; the horizontal angle turns around it. Between measured directions
the intensity is bilinear in the two angles. A file that leaves out angles means symmetry: one
horizontal angle is a body of revolution, 0 to 90 degrees mirrors into the other quadrants, 0 to 180
into the other half [1].

[1] ANSI/IES LM-63-19, Standard file format for the electronic transfer of photometric data.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foundation.documents import read_text
from scenes.errors import SceneError

MOST_ANGLES = 1000
TYPE_C = 1
FIGURES_BEFORE_ANGLES = 13
"""Lamps, lumens, multiplier, two counts, type, unit, three sizes; ballast, a spare, watts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Distribution:
    """Relative intensity, largest value 1, against angles in degrees.

    Attributes:
        vertical: from the axis, rising, (V,).
        horizontal: around it, rising, (H,).
        relative: (H, V).
    """

    vertical: NDArray[np.float64]
    horizontal: NDArray[np.float64]
    relative: NDArray[np.float64]

    def at(self, vertical: ArrayLike, horizontal: ArrayLike) -> NDArray[np.float64]:
        """The relative intensity in some directions, angles in degrees; 0 beyond the table."""
        v, h = (np.asarray(a, dtype=np.float64) for a in (vertical, horizontal))
        h = np.mod(h, 360.0)
        last = self.horizontal[-1]
        if last <= 180.0:
            h = np.where(h > 180.0, 360.0 - h, h)
        if last <= 90.0:
            h = np.where(h > 90.0, 180.0 - h, h)
        inside = (v >= self.vertical[0] - 1e-9) & (v <= self.vertical[-1] + 1e-9)
        j, b = _cell(self.vertical, v)
        if self.horizontal.size == 1:
            low = high = self.relative[0]
            value = low[j] * (1 - b) + high[j + 1] * b
        else:
            i, a = _cell(self.horizontal, h)
            table = self.relative
            value = (table[i, j] * (1 - a) + table[i + 1, j] * a) * (1 - b)
            value += (table[i, j + 1] * (1 - a) + table[i + 1, j + 1] * a) * b
        return np.where(inside, value, 0.0)


def _cell(
    nodes: NDArray[np.float64], at: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The cell of a rising table that each position falls in, and how far in."""
    index = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    part = (at - nodes[index]) / (nodes[index + 1] - nodes[index])
    return index, np.clip(part, 0.0, 1.0)


@functools.cache
def read_ies(name: str) -> Distribution:
    """The distribution in an IES file.

    Raises:
        SceneError: for a file that is not one, holds figures that cannot be, or is measured in
            another geometry than type C.
        DocumentError: for a file that cannot be read.
    """
    lines = read_text(Path(name)).splitlines()
    tilt = next((n for n, x in enumerate(lines) if x.strip().upper().startswith("TILT=")), None)
    if tilt is None:
        raise _not(name, "no line 'TILT='", "an IES file (LM-63)")
    if lines[tilt].strip().upper() != "TILT=NONE":
        raise _not(name, f"'{lines[tilt].strip()[:40]}'", "TILT=NONE")
    try:
        figures = [float(x) for x in " ".join(lines[tilt + 1 :]).replace(",", " ").split()]
    except ValueError as problem:
        raise _not(name, str(problem), "numbers after TILT=NONE") from None
    if len(figures) < FIGURES_BEFORE_ANGLES:
        raise _not(name, f"{len(figures)} numbers", f"at least {FIGURES_BEFORE_ANGLES}")
    across, around, kind = figures[3:6]
    if kind != TYPE_C:
        raise _not(name, f"photometry of type {kind:g}", "type C (1)")
    if not (2 <= across <= MOST_ANGLES and 1 <= around <= MOST_ANGLES):
        raise _not(name, f"{across:g} x {around:g} angles", f"2 x 1 to {MOST_ANGLES} each")
    v, h = int(across), int(around)
    rest = figures[FIGURES_BEFORE_ANGLES:]
    if len(rest) != v + h + v * h:
        raise _not(name, f"{len(rest)} numbers after the head", f"{v + h + v * h} for {v} x {h}")
    vertical, horizontal = np.array(rest[:v]), np.array(rest[v : v + h])
    candela = np.array(rest[v + h :]).reshape(h, v)
    if not np.isfinite(rest).all() or (candela < 0).any() or not candela.any():
        raise _not(name, "intensities that are negative, all zero or no numbers", "candela")
    if (np.diff(vertical) <= 0).any() or vertical[0] < 0 or vertical[-1] > 180:
        raise _not(name, "vertical angles that do not rise from 0 to 180", "that they do")
    ends = (0.0, 90.0, 180.0, 360.0)
    if (np.diff(horizontal) <= 0).any() or horizontal[0] != 0 or horizontal[-1] not in ends:
        raise _not(name, "horizontal angles that do not rise from 0 to 0, 90, 180 or 360", "it")
    return Distribution(vertical=vertical, horizontal=horizontal, relative=candela / candela.max())


def _not(name: str, found: str, expected: str) -> SceneError:
    return SceneError(f"{name} holds {found}", f"expected {expected}", "choose another IES file")
