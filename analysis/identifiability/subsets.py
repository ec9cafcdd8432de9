"""What some of the shots tell: which effects stand out, even from the best of any other.

Signatures of all effects are simulated once for all shots. For some of the shots, calibrated, the
signature s_i of an effect has a length and an angle to every other:

    d_ij = |s_i|^2 (1 - cos^2(s_i, s_j))

is the chi-squared that is left of effect i after the best amount of effect j. An effect is
separated where the smallest d_ij is that of five standard errors.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.calibration import calibration
from analysis.gap.calibrate.fit import Fit
from analysis.gap.measure.signature import Signature, scaled, signature, signed
from analysis.identifiability.limits import STANDARD_ERRORS, default_of
from sensor.effect import Effect

Floats = NDArray[np.float64]

NEEDED = STANDARD_ERRORS**2


@dataclass(frozen=True, kw_only=True, eq=False)
class Separability:
    """How well some shots show each effect, and tell it from every other one.

    Attributes:
        names: of the effects.
        seen: (effects,), chi-squared of each against none.
        apart: (effects, effects), chi-squared of the first after the best amount of the second;
            infinite on the diagonal.
    """

    names: tuple[str, ...]
    seen: Floats
    apart: Floats

    @property
    def least(self) -> Floats:
        """Chi-squared of each effect after the best amount of any other."""
        return np.asarray(np.minimum(self.apart.min(axis=1), self.seen))

    @property
    def separated(self) -> tuple[str, ...]:
        """Effects that stand out from none and from each other."""
        return tuple(n for n, d in zip(self.names, self.least, strict=True) if d >= NEEDED)

    @property
    def unseen(self) -> tuple[str, ...]:
        """Effects that these shots do not show at all."""
        return tuple(n for n, d in zip(self.names, self.seen, strict=True) if d < NEEDED)

    @property
    def merit(self) -> float:
        """How many effects are separated; those that are not yet count by how near they are."""
        return float(np.minimum(1.0, self.least / NEEDED).sum())

    @property
    def classes(self) -> list[list[str]]:
        """Groups of effects that are seen and that these shots confuse."""
        near = (self.apart < NEEDED) & (self.seen >= NEEDED)[:, None] & (self.seen >= NEEDED)
        near = near | near.T
        left = set(range(len(self.names)))
        groups = []
        while left:
            group, edge = set[int](), {min(left)}
            while edge:
                group |= edge
                edge = {int(j) for i in edge for j in np.flatnonzero(near[i])} - group
            left -= group
            if len(group) > 1:
                groups.append([self.names[k] for k in sorted(group)])
        return groups


def told(rows: Floats, names: Sequence[str], either_way: Sequence[bool]) -> Separability:
    """Lengths and angles of calibrated signatures.

    Args:
        rows: one signature each.
        names: of the effects.
        either_way: whether an effect may have either sign; others are only ever added.
    """
    products = rows @ rows.T
    seen = np.diag(products).copy()
    along = np.where(np.array(either_way)[None, :], products, np.maximum(products, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        taken = np.where(seen > 0, along**2 / seen, 0.0)
    apart = np.maximum(seen[:, None] - taken, 0.0)
    np.fill_diagonal(apart, np.inf)
    return Separability(names=tuple(names), seen=seen, apart=apart)


@dataclass(frozen=True, kw_only=True, eq=False)
class Prediction:
    """A camera under every shot that is considered, and how each effect would show in them."""

    known: Fit
    signatures: tuple[Signature, ...]

    def told_by(self, labels: Sequence[str], groups: int) -> Separability:
        """What some of the shots tell with so many groups of frames each."""
        part = only(self.known, labels)
        space = part.space(groups)
        turned = calibration(space, part.ways)
        figures = [key.shot in set(labels) for key in self.known.bodies.keys]
        shots = [self.known.bodies.shots.index(label) for label in part.bodies.shots]
        rows = np.array([space.vector(s.figures[figures], s.means[shots]) for s in self.signatures])
        return told(
            turned.left(rows),
            [s.effect.name for s in self.signatures],
            [signed(type(s.effect)) for s in self.signatures],
        )


def only(known: Fit, labels: Sequence[str]) -> Fit:
    """A fit with some of its shots."""
    bodies = known.bodies
    figures = np.array([key.shot in set(labels) for key in bodies.keys])
    names = tuple(label for label in bodies.shots if label in set(labels))
    shots = [bodies.shots.index(label) for label in names]
    return dataclasses.replace(
        known,
        scenery=known.scenery.only(names),
        bodies=dataclasses.replace(
            bodies,
            keys=tuple(key for key, kept in zip(bodies.keys, figures, strict=True) if kept),
            figures=bodies.figures[:, figures],
            shots=names,
            means=bodies.means[:, shots],
            noise=bodies.noise[shots],
        ),
        variances=known.variances[figures],
        shares=known.shares[figures],
        more=known.more.only(shots),
        ways=dataclasses.replace(
            known.ways,
            figures=known.ways.figures[:, figures],
            means=known.ways.means[:, shots],
        ),
    )


def predict(
    known: Fit,
    kinds: Iterable[type[Effect]],
    strength: float,
    watch: Callable[[str], None] = lambda name: None,
) -> Prediction:
    """Simulate every effect at a part of its default strength in every shot of a fit."""
    made = []
    for kind in kinds:
        watch(kind.name)
        effect = scaled(default_of(kind), strength)
        shown = signature(effect, known)
        if shown is not None:
            made.append(shown)
    return Prediction(known=known, signatures=tuple(made))
