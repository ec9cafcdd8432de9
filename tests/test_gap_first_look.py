"""The first look at all suspects: what it may leave out, and what a second look adds."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.look.observation import Key
from analysis.gap.measure.signature import Signature
from analysis.gap.suspects import first_look
from analysis.gap.suspects.first_look import (
    LITTLE,
    WEAKEST,
    closer,
    confirmed,
    either_way,
    in_range,
    promise,
    weaker,
)
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.hot_pixels import HotPixels
from sensor.effects.lateral_chromatic_aberration import LateralChromaticAberration
from sensor.effects.sharpening import Sharpening

FAMILIES = np.repeat(["codes", "rows", "time"], [20, 300, 300])
KEYS = tuple(Key(shot="a", lattice="Y", family=f, statistic=str(k)) for k, f in enumerate(FAMILIES))


NOTHING = np.zeros((1, 1, 1))
"""An image of one block that does not change."""


def shown(
    figures: np.ndarray,
    effect: Effect | None = None,
    keys: tuple[Key, ...] = KEYS,
    sets: int = 1,
) -> Signature:
    """A signature of figures alone, which all sets agree on."""
    return Signature(
        effect=effect or catalogue()["adc_dnl"](),
        keys=keys,
        figures=figures,
        means=NOTHING,
        plain=(figures, NOTHING),
        sets=sets,
        base=None,  # type: ignore[arg-type]
        scenery=None,  # type: ignore[arg-type]
    )


def case(left: np.ndarray) -> Any:
    """A capture of which calibration takes nothing up, in units of standard errors."""
    space = SimpleNamespace(keys=KEYS, vector=lambda figures, means: figures)
    turned = SimpleNamespace(space=space, left=lambda vector: vector)
    spread = SimpleNamespace(families=FAMILIES)
    return SimpleNamespace(
        fitting=SimpleNamespace(turned=turned, spread=spread), fit_left=left, known=None
    )


def test_what_changes_the_picture_is_looked_at_either_way() -> None:
    """Fringes the other way move the mean image the other way and leave as much power: an amount
    below zero fits one of the two. A kind that has one sign, or does not show in the picture, is
    looked at once."""
    out = LateralChromaticAberration(red_px=0.5, blue_px=-0.4)
    assert either_way(out) == (out, LateralChromaticAberration(red_px=-0.5, blue_px=0.4))
    for once in (HotPixels(), BlackLevelOffset(offset_e=5.0)):
        assert either_way(once) == (once,)


def test_a_promise_is_never_less_than_what_is_kept() -> None:
    """One amount for all families takes off no more than one for each. What a signature has in the
    codes is whole there, however much noise the other families have; of the fall of chi-squared as
    a whole, |s|^2 / (|s|^2 + |noise|^2) is left."""
    rng = np.random.default_rng(51)
    for _ in range(50):
        signature, left = rng.standard_normal((2, len(KEYS)))
        whole = max(0.0, signature @ left) ** 2 / (signature @ signature)
        assert promise(case(left), shown(signature)) >= whole
    truth = np.where(FAMILIES == "codes", 12.0, 0.0)
    noise = np.where(FAMILIES == "codes", 0.0, 6.0) * rng.standard_normal(len(KEYS))
    fall = (truth @ truth) ** 2 / (truth @ truth + noise @ noise)
    assert fall < 0.2 * (truth @ truth)
    assert promise(case(truth), shown(truth + noise)) == pytest.approx(truth @ truth)


def test_what_goes_the_other_way_promises_nothing() -> None:
    """Steps of a converter are as they are or more uneven; a dark current may be more or less."""
    left = np.where(FAMILIES == "codes", 5.0, 0.0)
    assert promise(case(left), shown(-left)) == 0.0
    either_way = next(n for n, kind in catalogue().items() if first_look.signed(kind))
    assert promise(case(left), shown(-left, catalogue()[either_way]())) == pytest.approx(
        left @ left
    )


def test_a_second_look_goes_to_those_that_promise_something(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of three with 100 %, 8 % and 2 % of the best promise two are looked at again, and neither is
    a third time."""
    asked: list[float] = []

    def again(one: Signature, second: Signature | None, known: object) -> Signature:
        assert second is other
        asked.append(float(one.figures.max()))
        return shown(one.figures, sets=2)

    other = shown(np.zeros(len(KEYS)))
    monkeypatch.setattr(first_look, "begun_signature", lambda effect, known, seeds: lambda: other)
    monkeypatch.setattr(first_look, "confirmed", again)
    left = np.where(FAMILIES == "rows", 10.0, 0.0)
    parts = [np.where(np.arange(len(KEYS)) < n, 1.0, 0.0) + 0.0 for n in (320, 20 + 24, 20 + 6)]
    first = [shown(k * part) for k, part in zip((1.0, 2.0, 3.0), parts, strict=True)]
    second = closer(case(left), first)
    assert [one.sets for one in second] == [2, 2, 1]
    assert asked == [1.0, 2.0]
    closer(case(left), second)
    assert asked == [1.0, 2.0]
    assert all(one.sets == 1 for one in closer(case(left), first, least=1e9))


def test_two_looks_keep_what_they_agree_on() -> None:
    """What both show stays; noise that each has for itself is drawn to nothing."""
    rng = np.random.default_rng(53)
    truth = np.where(FAMILIES == "codes", 40.0, 0.0)
    one, other = (shown(truth + rng.standard_normal(len(KEYS))) for _ in range(2))
    reference = SimpleNamespace(keys=KEYS, lit=frozenset({"a"}), means=NOTHING[None])
    known = SimpleNamespace(references={first_look.SEEDS[0]: reference})
    both = confirmed(one, other, known)  # type: ignore[arg-type]
    assert both.sets == 2
    assert both.figures[FAMILIES == "codes"] == pytest.approx(40.0, abs=4.0)
    outside = both.figures[FAMILIES != "codes"]
    mean = ((one.figures + other.figures) / 2)[FAMILIES != "codes"]
    assert outside @ outside < 0.5 * (mean @ mean)


def test_who_cannot_be_looked_at_again_stays_as_seen() -> None:
    """A later model may have an effect with which this one cannot be."""
    one = shown(np.ones(len(KEYS)))
    assert confirmed(one, None, None) is one  # type: ignore[arg-type]


def test_frames_may_say_more_than_an_effect_can() -> None:
    """A search begins at the end of the range then, colour by colour, and not with an error."""
    said = {"density": 0.003, "rate_e_per_s": 5e6, "period_px": 9.0}
    assert in_range(HotPixels, said) == {"density": 0.003, "rate_e_per_s": 1e6}
    assert HotPixels(**in_range(HotPixels, said)).rate_e_per_s == 1e6  # type: ignore[arg-type]
    room = in_range(AmbientLight, {"rate_e_per_s": Colours(R=-1.0, G=2.0, B=3.0)})
    assert room == {"rate_e_per_s": Colours(R=0.0, G=2.0, B=3.0)}


def test_what_is_done_to_pictures_is_looked_at_as_weak_as_it_could_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A signature that grows with the strength has 100 times the chi-squared that is seen well at
    10 times the strength that would have it. One that is about right, one that is no processing
    and a capture in which much is off need no other look."""
    monkeypatch.setattr(
        first_look,
        "begun_signature",
        lambda effect, known, seeds: lambda: shown(np.ones(1), effect),
    )
    size = np.sqrt(LITTLE / len(KEYS)) * np.ones(len(KEYS))
    seen = [
        shown(10 * size, Sharpening(amount=0.5, passes=1)),
        shown(2 * size, Sharpening(amount=0.5, passes=2)),
        shown(10 * size, HotPixels()),
    ]
    little, much = case(size), case(size)
    little.misfit, much.misfit = 1.0, 9.0
    (one,) = weaker(little, seen)
    assert isinstance(one.effect, Sharpening)
    assert one.effect.amount == pytest.approx(0.05)
    assert one.effect.passes == 1
    assert weaker(much, seen) == []
    # one a hundred million times as long is no straight line
    (one,) = weaker(little, [shown(1e4 * size, Sharpening(amount=0.5, passes=1))])
    assert isinstance(one.effect, Sharpening)
    assert one.effect.amount == pytest.approx(WEAKEST * 0.5)
