"""Detection limits of the bench, and the strengths that follow them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.measure.case import BORROWED, variance_along
from analysis.gap_bench.cases import Case
from analysis.gap_bench.draw import (
    begun,
    effects_of,
)
from analysis.gap_bench.severity import severity_of
from analysis.identifiability.limits import (
    STANDARD_ERRORS,
    between,
    default_of,
    effect_of,
    error_between,
    limit_of,
)
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.jpeg import Jpeg
from sensor.effects.row_noise import RowNoise
from tests.bench_limits import limit


def test_strength_follows_the_detection_limit_and_its_range() -> None:
    known = {
        "row_noise": limit("row_noise", parameters={"sigma_e": {"value": 2.0, "unit": "e-"}}),
        "bit_truncation": limit("bit_truncation", steps=True, z=40.0),
    }
    for severity in (1.0, 4.0):
        case = Case(kind="effect", effects=("row_noise",), severity=severity)
        (made,) = effects_of(case, known)
        assert isinstance(made, RowNoise)
        assert made.sigma_e == pytest.approx(2.0 * case.strength)
        assert severity <= case.strength < 2.0 * severity
    strongest = next(p.maximum for p in RowNoise.parameters() if p.name == "sigma_e")
    weak = limit("row_noise", parameters={"sigma_e": {"value": strongest / 2, "unit": "e-"}})
    case = Case(kind="effect", effects=("row_noise",), severity=8.0)
    assert "cannot be" in str(effects_of(case, {"row_noise": weak}))
    assert "not seen" in str(effects_of(case, {"row_noise": limit("row_noise", z=1.0)}))
    whole = Case(kind="effect", effects=("bit_truncation",), severity=1.0)
    assert effects_of(whole, known) == (BitTruncation(bits=2.0),)


def test_what_comes_in_steps_is_drawn_with_all_its_choices() -> None:
    """Of 60 draws of v choices each misses one with a chance of v (1 - 1/v)^60: 6e-6 for 5."""
    algorithms, bits, rows_of_colour = set(), set(), set()
    for seed in range(60):
        names = ("bit_truncation", "chroma_subsampling", "demosaic_other", "row_noise")
        lost, colour, filled, noise = begun(Case(kind="effect", effects=names, seed=seed))
        algorithms.add(filled.values()["algorithm"])
        bits.add(lost.values()["bits"])
        rows_of_colour.add(colour.values()["rows"])
        assert noise == RowNoise()
    assert algorithms == {1.0, 2.0, 3.0, 4.0, 5.0}
    assert bits == {1.0, 2.0, 3.0}
    assert rows_of_colour == {1.0, 2.0}


@pytest.mark.parametrize("power", [1.0, 2.0])
@pytest.mark.parametrize("per_e", [0.02, 30.0])
def test_a_limit_is_where_five_standard_errors_are(power: float, per_e: float) -> None:
    def seen(effect: Any) -> tuple[float, float]:
        z = (per_e * effect.sigma_e) ** power
        return z**2, 2 * z**2

    found = limit_of(RowNoise(), seen)
    assert found.z == pytest.approx(STANDARD_ERRORS, rel=0.06)
    assert found.absorbed == pytest.approx(0.5)
    assert effect_of(found, RowNoise).sigma_e == pytest.approx(  # type: ignore[attr-defined]
        STANDARD_ERRORS ** (1 / power) / per_e, rel=0.06
    )


def test_a_limit_beyond_the_range_and_one_that_comes_in_steps_say_so() -> None:
    assert not limit_of(RowNoise(), lambda effect: (1e-6 * effect.sigma_e, 1.0)).reached
    assert limit_of(BitTruncation(), lambda effect: (900.0, 900.0)).steps


def test_products_of_different_draws_have_no_noise_of_their_own() -> None:
    """Mean of |s|^2 over 400 trials within 4.5 standard errors; the square would have 1000 more."""
    draw = np.random.default_rng(1)
    signal = np.zeros(1000)
    signal[0] = 3.0
    found = [between(signal + draw.standard_normal((4, 1000))) for _ in range(400)]
    assert abs(np.mean(found) - 9.0) < 4.5 * np.std(found) / np.sqrt(len(found))


def test_the_error_of_a_mean_product_is_that_of_its_scatter() -> None:
    """Jackknife against 400 trials, within 4.5 standard errors: 6 draws know it to a third each."""
    draw = np.random.default_rng(2)
    signal = np.zeros(200)
    signal[0] = 8.0
    drawn = [signal + draw.standard_normal((6, 200)) for _ in range(400)]
    scatter = np.std([between(rows) for rows in drawn])
    squares = np.array([error_between(rows) ** 2 for rows in drawn])
    error = np.hypot(squares.std() / np.sqrt(400), scatter**2 * np.sqrt(2 / 400))
    # the jackknife counts the products of two draws' noise twice: a part of 200 / (200 + 4 * 320)
    assert scatter**2 - 4.5 * error < squares.mean() < 1.3 * scatter**2 + 4.5 * error


def test_figures_that_have_something_in_common_tell_less() -> None:
    """Twins that scatter with a variance of 4 along a direction: 200, and 6 that are borrowed."""
    draw = np.random.default_rng(3)
    residuals = draw.standard_normal((200, 2)) * [2.0, 1.0]
    spread: Any = SimpleNamespace(residuals=residuals)
    along, across = (variance_along(spread, np.array(d)) for d in ([3.0, 0.0], [0.0, 3.0]))
    # 4.5 standard errors of a variance of 200
    assert along == pytest.approx((200 * 4 + BORROWED) / (200 + BORROWED), rel=4.5 * 0.1)
    assert 1.0 <= across < 1.0 + 4.5 * 0.1
    assert variance_along(spread, np.zeros(2)) == 1.0


@pytest.mark.parametrize("z", [100.0, 1e4])
def test_what_begins_at_a_threshold_is_found_there_and_counts_as_strong(z: float) -> None:
    def seen(effect: Any) -> tuple[float, float]:
        chi2 = z**2 if effect.sigma_e > 7.0 else 0.0
        return chi2, chi2

    found = limit_of(RowNoise(), seen)
    assert effect_of(found, RowNoise).sigma_e == pytest.approx(7.0, rel=0.1)  # type: ignore[attr-defined]
    assert found.z == pytest.approx(z)
    case = Case(kind="effect", effects=("row_noise",), severity=2.0)
    assert severity_of(case, found) == pytest.approx(case.strength * z / STANDARD_ERRORS)
    assert severity_of(case, limit("row_noise", z=5.2)) == case.strength
    assert severity_of(case, limit("row_noise", z=40.0, steps=True)) == 8.0


def test_an_effect_without_a_strength_is_taken_at_its_default() -> None:
    assert default_of(Jpeg) == Jpeg()
