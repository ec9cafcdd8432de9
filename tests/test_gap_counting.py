"""A converter of more bits is taken for the cause of uneven codes where it is likelier as a whole.

With L the likelihood of all figures, -2 ln L falls by as much as the figures of histograms fall if
these are independent. They are not: the same few codes are counted by their place in 2, 4 and 8.
"""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from analysis.gap.calibrate import counting
from analysis.gap.calibrate.counting import UNEVEN, in_finer_codes, without_gains
from analysis.gap.calibrate.refine import FAR
from analysis.gap.look.arithmetic import FINER, OF_64THS
from sensor.effects.white_balance import WhiteBalance
from tests.candidates import BASE

NOTHING: Any = None

GAINS = WhiteBalance(red_gain=1.0, blue_gain=0.9635)


def model(arithmetic: int, *, uneven: float, deviance: float) -> Any:
    """A camera against frames, as far as ways of counting are told by it."""
    base = SimpleNamespace(arithmetic=arithmetic)
    return SimpleNamespace(
        base=base, effects=(), uneven=uneven, deviance=deviance, misfit=1.0, chi2=deviance
    )


@pytest.mark.parametrize(
    ("uneven", "deviance", "taken"),
    [
        (1.0, 900.0, True),  # even, and likelier
        (1.0, 1080.0, False),  # even by chance: a few codes of one dark
        (0.8 * UNEVEN, 900.0, False),  # something else is uneven
    ],
)
def test_finer_codes_are_likelier_and_even(
    monkeypatch: pytest.MonkeyPatch, uneven: float, deviance: float, taken: bool
) -> None:
    found = model(0, uneven=1.2 * UNEVEN, deviance=1000.0)
    finer = model(11, uneven=uneven, deviance=deviance)
    monkeypatch.setattr(counting, "unevenness", lambda one: one.uneven)
    monkeypatch.setattr(counting, "finer", lambda *_: iter([finer.base]))
    for step in ("refined", "further"):
        monkeypatch.setattr(counting, step, lambda *_: finer)
    assert (in_finer_codes(found, NOTHING, NOTHING) is finer) is taken


def test_even_codes_are_left_alone() -> None:
    """Nothing is simulated."""
    found = model(0, uneven=0.0, deviance=1000.0)
    found.space, found.gap = SimpleNamespace(keys=()), ()
    assert in_finer_codes(found, NOTHING, NOTHING) is found


@pytest.mark.parametrize(
    ("gains", "arithmetic", "plain", "kept"),
    [
        (GAINS, 0, 900.0, False),  # waves made the comb
        (GAINS, 0, 1100.0, True),
        (GAINS, FINER[0], 900.0, True),  # pixels told it
        (None, 0, 900.0, True),  # there are none
    ],
)
def test_gains_of_whole_codes_are_there_if_twins_have_the_comb(
    monkeypatch: pytest.MonkeyPatch,
    gains: WhiteBalance | None,
    arithmetic: int,
    plain: float,
    kept: bool,
) -> None:
    other = model(arithmetic, uneven=0.0, deviance=plain)
    found = model(arithmetic, uneven=0.0, deviance=1000.0)
    found.base.white_balance, found.base.plain = gains, lambda: other.base
    for step in ("refined", "further"):
        monkeypatch.setattr(counting, step, lambda *_: other)
    assert (without_gains(found, NOTHING, NOTHING) is found) is kept


@pytest.mark.parametrize(
    ("even", "uneven_darks", "taken"),
    [
        (True, 20.0, True),  # darks are even with it
        (False, 20.0, False),  # darks are not, so that something else is the cause
        (True, 1.0, False),  # darks were even before
    ],
)
def test_darks_tell_finer_codes_whatever_is_wrong_with_the_light(
    monkeypatch: pytest.MonkeyPatch, even: bool, uneven_darks: float, taken: bool
) -> None:
    """A patch of light on the chart leaves a misfit of 5, and darks of a camera of 10 bits that
    gives 8 look as before."""
    found = model(0, uneven=110.0, deviance=1000.0)
    found.misfit = 2.5 * FAR
    finer = model(9, uneven=5.0, deviance=900.0)
    darks = {id(found): uneven_darks, id(finer): 1.4 if even else 30.0}
    monkeypatch.setattr(counting, "unevenness", lambda one: one.uneven)
    monkeypatch.setattr(counting, "uneven_in_the_dark", lambda one: darks[id(one)])
    monkeypatch.setattr(counting, "finer", lambda *_: iter([finer.base]))
    for step in ("refined", "further"):
        monkeypatch.setattr(counting, step, lambda *_: finer)
    assert (in_finer_codes(found, NOTHING, NOTHING) is finer) is taken


@pytest.mark.parametrize(("fills_in", "ways"), [(True, set(FINER)), (False, {OF_64THS})])
def test_halves_up_behind_a_finer_converter_are_a_way_of_counting(
    fills_in: bool, ways: set[int]
) -> None:
    """Means of four samples reach halves less often than the samples themselves, which halves up
    raise by half a step: in darks of little noise they stand on other codes. Where nothing is
    filled in they move all codes alike."""
    scenery: Any = SimpleNamespace(body=SimpleNamespace(fills_in=fills_in))
    base = dataclasses.replace(BASE, arithmetic=0)
    assert {one.arithmetic for one in counting.finer(base, scenery)} == ways
