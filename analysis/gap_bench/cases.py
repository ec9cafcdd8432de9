"""The cases of the bench: nulls, every effect at four strengths, pairs, and withheld effects."""

from __future__ import annotations

import dataclasses
import hashlib
from dataclasses import dataclass
from typing import Literal

import numpy as np

from sensor.catalogue import catalogue

Kind = Literal["null", "effect", "withheld", "pair"]

SEVERITIES = (1.0, 2.0, 4.0, 8.0)
"""Least strengths of an effect in its detection limits: each case is up to twice as strong."""

WITHHELD_SEVERITIES = (2.0, 4.0, 8.0)
PAIR_SEVERITY = 4.0

NULLS = 400
SEEDS = 5
WITHHELD_SEEDS = 2
PAIRS = 150


@dataclass(frozen=True, kw_only=True)
class Case:
    """One capture to diagnose.

    Attributes:
        kind: null has no effect; withheld has one that the diagnosis is not told of.
        effects: names of what is in the frames.
        severity: least strength of each in detection limits.
        seed: number of the case among its like.
        bench_seed: another one gives the same list of cases with other cameras and noise.
    """

    kind: Kind
    effects: tuple[str, ...] = ()
    severity: float = 0.0
    seed: int = 0
    bench_seed: int = 0

    @property
    def key(self) -> str:
        """Its name."""
        return f"{self.kind}:{'+'.join(self.effects)}:{self.severity:g}:{self.seed}"

    @property
    def number(self) -> int:
        """Seed of everything random in it, and its place in the order.

        By a hash that scatters: sums of similar names, as CRC-32 makes them, lie side by side.
        """
        name = f"{self.key}/{self.bench_seed}".encode()
        return int.from_bytes(hashlib.blake2b(name, digest_size=4).digest())

    @property
    def strength(self) -> float:
        """Of its effect in detection limits: in a band of severities all are as likely, by their
        logarithm. Effects of a pair are all of one strength.
        """
        if self.kind == "pair":
            return self.severity
        return self.severity * float(2.0 ** np.random.default_rng((self.number, 2)).uniform())


def suspects() -> list[str]:
    """Names of all effects that are not in the base camera."""
    return [name for name, kind in catalogue().items() if not kind.base]


def all_cases(bench_seed: int = 0) -> dict[str, Case]:
    """Every case by name, in an order that is random but always the same for one seed.

    Args:
        bench_seed: of the cameras, the noise, the pairs and the order.
    """
    names = suspects()
    made = [Case(kind="null", seed=seed) for seed in range(NULLS)]
    for name in names:
        made += [
            Case(kind="effect", effects=(name,), severity=severity, seed=seed)
            for severity in SEVERITIES
            for seed in range(SEEDS)
        ]
        made += [
            Case(kind="withheld", effects=(name,), severity=severity, seed=seed)
            for severity in WITHHELD_SEVERITIES
            for seed in range(WITHHELD_SEEDS)
        ]
    draw = np.random.default_rng((PAIRS, bench_seed))
    for seed in range(PAIRS):
        first, second = sorted(draw.choice(len(names), size=2, replace=False))
        pair = (names[first], names[second])
        made.append(Case(kind="pair", effects=pair, severity=PAIR_SEVERITY, seed=seed))
    made = [dataclasses.replace(case, bench_seed=bench_seed) for case in made]
    made.sort(key=lambda case: case.number)
    return {case.key: case for case in made}
