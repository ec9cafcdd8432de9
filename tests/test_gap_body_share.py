"""Which part of a figure's scatter is the body's: told by looking at several bodies twice."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.calibrate.body_share import (
    BORROWED,
    PAIRS,
    USUAL,
    body_share,
    share_of_amounts,
    usual_share,
)
from analysis.gap.look.observation import Key, Observation

BODIES, LATTICES = 64, 40
KINDS = (
    ("tails", "skewness"),
    ("rows", "row correlation"),
    ("pattern lines", "row pattern"),
    ("dark surface", "slope down"),
)


def observed(keys: tuple[Key, ...], figures: np.ndarray) -> Observation:
    """As many groups of frames, of which only figures matter here."""
    return Observation(
        keys=keys, figures=figures, shots=("dark",), lit=frozenset(), channels=("Y",),
        means=np.zeros((len(figures), 1, 1, 1)), noise=np.ones((1, 1)), grid=(1, 1), samples=1,
        frames=4, counted=4,
    )  # fmt: skip


def keys_of(*kinds: tuple[str, str]) -> tuple[Key, ...]:
    """Keys of each kind in every lattice of a dark shot."""
    return tuple(
        Key(shot="dark", lattice=f"Y{k}", family=family, statistic=statistic)
        for family, statistic in kinds
        for k in range(LATTICES)
    )


def test_the_share_is_the_covariance_of_two_looks() -> None:
    """Figures of variance 1 whose bodies have a variance of 0.7, 0 and 0.4: they come out so, drawn
    to the usual share by what that is worth, which is 1 for lines of a pattern. Of a surface the
    name says that all is the body's. A mean of n products of that correlation has the error
    sqrt((1 + r^2) / n): at 4.5 standard errors for three tests."""
    rng = np.random.default_rng(4)
    true = np.repeat([0.7, 0.0, 0.4, 0.4], LATTICES)
    body = np.sqrt(true) * rng.standard_normal((BODIES, true.size))
    first, again = (
        body + np.sqrt(1 - true) * rng.standard_normal((BODIES, true.size)) for _ in range(2)
    )
    keys = keys_of(*KINDS)
    found = body_share(observed(keys, first), observed(keys, again))
    n = BODIES * LATTICES
    for place, (share, usual) in enumerate([(0.7, USUAL), (0.0, USUAL), (0.4, 1.0)]):
        expected = (n * share + BORROWED * usual) / (n + BORROWED)
        error = np.sqrt((1 + share**2) / n)
        assert found[place * LATTICES] == pytest.approx(expected, abs=4.5 * error)
    assert np.all(found[3 * LATTICES :] == 1.0)


def test_an_amount_is_the_bodys_more_than_its_figures_are() -> None:
    """What n figures have of a body they have in common, and the noise of each is its own: their
    mean has n s / (1 + (n - 1) s) of the body. Of figures that have nothing in common no less than
    their own share is believed."""
    rng = np.random.default_rng(12)
    count, figures, share = 4000, 8, 0.5
    body = np.sqrt(share) * rng.standard_normal((count, 1))
    first, again = (
        (body + np.sqrt(1 - share) * rng.standard_normal((count, figures))).mean(axis=1)
        for _ in range(2)
    )
    alone = rng.standard_normal((2, count))
    found = share_of_amounts(
        np.column_stack([first, alone[0]]),
        np.column_stack([again, alone[1]]),
        np.array([share, 0.1]),
    )
    true = figures * share / (1 + (figures - 1) * share)
    expected = (count * true + PAIRS * share) / (count + PAIRS)
    assert found[0] == pytest.approx(expected, abs=4.5 * (1 - true**2) / np.sqrt(count))
    assert found[1] == 0.1


def variance_of(noise_dn: float, fixed_dn: np.ndarray, rng: np.random.Generator) -> float:
    """Logarithm of the variance in time of whole codes, of one group of four darks."""
    darks = np.round(4.3 + fixed_dn + noise_dn * rng.standard_normal((4, *fixed_dn.shape)))
    return float(np.log(darks.var(axis=0, ddof=1).mean() + 1 / 12))


@pytest.mark.parametrize(("noise_dn", "least", "most"), [(0.2, 0.6, 1.0), (1.0, 0.0, 0.2)])
def test_rounding_makes_noise_in_time_the_bodys(noise_dn: float, least: float, most: float) -> None:
    """Columns with offsets of 0.2 DN: below a step of the converter they decide which samples
    change their code at all, and another body's noise is another one for good; from one step on
    the noise hides them. An assumed share would be wrong for one of the two."""
    rng = np.random.default_rng(11)
    keys = keys_of(("transfer", "variance"))
    first, again = np.empty((2, BODIES, LATTICES))
    for k in np.ndindex(BODIES, LATTICES):
        columns = np.broadcast_to(0.2 * rng.standard_normal(32), (32, 32))
        first[k], again[k] = (variance_of(noise_dn, columns, rng) for _ in range(2))
    found = body_share(observed(keys, first), observed(keys, again))
    assert least <= found[0] <= most
    assert usual_share(keys)[0] == USUAL
