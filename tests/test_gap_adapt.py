"""A suspect at the strength that it seems to have: found on its clearest signature."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.calibrate import fit
from analysis.gap.look.observation import Key
from analysis.gap.measure.signature import Signature, hold
from analysis.gap.suspects import adapt
from sensor.effect import Effect
from sensor.effects.row_noise import RowNoise
from tests.test_gap_first_look import shown

FIGURES = 400
KEYS = tuple(Key(shot="a", lattice="Y", family="rows", statistic=str(k)) for k in range(FIGURES))
DEFAULT_E = RowNoise().sigma_e


def capture(left: np.ndarray) -> Any:
    """A capture of which calibration takes nothing up, in units of standard errors."""
    families = np.full(FIGURES, "rows")
    space = SimpleNamespace(keys=KEYS, families=families, vector=lambda figures, means: figures)
    turned = SimpleNamespace(space=space, left=lambda vector: vector)
    known = SimpleNamespace(effects=())
    return SimpleNamespace(fitting=SimpleNamespace(turned=turned), fit_left=left, known=known)


SHAPE = np.random.default_rng(3).standard_normal(FIGURES)
SHAPE /= np.linalg.norm(SHAPE)


def simulated(shows: Callable[[float], float]) -> Callable[..., Signature]:
    """What an effect shows of one shape at its strength, and noise that is as long as 20."""
    noise = np.random.default_rng(4).standard_normal(FIGURES)

    def signature(effect: Effect, known: Any) -> Signature:
        assert isinstance(effect, RowNoise)
        figures = shows(effect.sigma_e / DEFAULT_E) * SHAPE + noise
        return shown(figures, effect, KEYS, sets=2)

    return signature


def linear(strength: float) -> float:
    return 500.0 * strength


def of_a_variance(strength: float) -> float:
    return 500.0 * strength**2


def from_a_threshold(strength: float) -> float:
    return 500.0 * max(0.0, strength - 0.05)


@pytest.mark.parametrize("shows", [linear, of_a_variance, from_a_threshold])
def test_a_weak_effect_has_the_strength_that_shows_as_much(
    monkeypatch: pytest.MonkeyPatch, shows: Callable[[float], float]
) -> None:
    """An effect that stands eight standard errors from zero, of which the default strength shows
    500: whatever the law by which it grows, the strength is that which shows 8. The signature at
    that strength is drowned in noise that is as long as 20, that of the default is not. Both have
    the same noise: 20^2 / 500 of it are in their product, and along the shape one standard error,
    here two at most, so that of 8 they are (2 + 0.8) / 8."""
    truth = next(s for s in np.geomspace(1e-3, 1.0, 4000) if shows(s) > 8.0)
    signature = simulated(shows)
    monkeypatch.setattr(adapt, "signature", signature)
    case = capture(shows(truth) * SHAPE)
    found = hold(signature(RowNoise(), None), case.fitting.turned, case.fit_left)
    adapted = adapt.adapted(case, found)
    assert isinstance(adapted.effect, RowNoise)
    assert adapted.effect.sigma_e / DEFAULT_E == pytest.approx(truth, rel=0.35)
    assert adapted.clearest.score > 0.9 * 8.0**2
    own = hold(signature(adapted.effect, None), case.fitting.turned, case.fit_left)
    assert own.score < 0.5 * adapted.clearest.score


def test_between_nothing_and_too_much_it_is_looked_for_by_halves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Above a threshold at 0.6 of the default strength an effect grows as the fourth power, the
    steepest that is believed, of what is beyond: 8 of 500 are shown by

        s = 0.6 + 0.4 (8 / 500)^(1/4) = 0.742

    and powers of the strength itself lead to 0.36, where there is nothing."""
    truth = 0.6 + 0.4 * (8.0 / 500.0) ** 0.25

    def shows(strength: float) -> float:
        return 500.0 * (max(0.0, strength - 0.6) / 0.4) ** 4

    def signature(effect: Effect, known: Any) -> Signature:
        assert isinstance(effect, RowNoise)
        return shown(shows(effect.sigma_e / DEFAULT_E) * SHAPE, effect, KEYS, sets=2)

    monkeypatch.setattr(adapt, "signature", signature)
    case = capture(8.0 * SHAPE)
    found = hold(signature(RowNoise(), None), case.fitting.turned, case.fit_left)
    adapted = adapt.adapted(case, found)
    assert isinstance(adapted.effect, RowNoise)
    assert adapted.effect.sigma_e / DEFAULT_E == pytest.approx(truth, rel=0.1)


def test_what_grows_by_no_power_of_its_strength_stays_where_it_is_clearest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where photosites are full, half of the charge shows another picture, not twice the first: two
    and a half times of the clearest signature is no reason to go there."""
    other = np.random.default_rng(5).standard_normal(FIGURES)
    other *= 3e4 / np.linalg.norm(other)

    def signature(effect: Effect, known: Any) -> Signature:
        assert isinstance(effect, RowNoise)
        near = effect.sigma_e / DEFAULT_E < 1.2
        return shown(100.0 * SHAPE if near else other, effect, KEYS, sets=2)

    monkeypatch.setattr(adapt, "signature", signature)
    case = capture(250.0 * SHAPE)
    found = hold(signature(RowNoise(), None), case.fitting.turned, case.fit_left)
    adapted = adapt.adapted(case, found)
    assert adapted.effect == found.effect
    assert adapted.nearest is adapted.clearest


def test_signatures_come_of_twins_that_are_not_in_the_mean() -> None:
    """What a change does to a figure goes with the noise of that figure, and the mean of the twins
    has a part of that noise if they are among them."""
    assert not set(fit.FINAL_SEEDS) & set(fit.seeds_of(fit.TWINS))
    assert set(fit.TURNED_SEEDS) <= set(fit.seeds_of(fit.TWINS))
