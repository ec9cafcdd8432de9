"""Which shots and frames take part, and which families have a say."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.look.shots import plan
from analysis.gap.measure.distance import distance
from analysis.gap.measure.twins_spread import Spread
from sensor.frames import Capture, Frames
from sensor.protocol import Shot


def stack(label: str, frames: int, *, lit: bool) -> Frames:
    light = ("lamp",) if lit else ("none",)
    shot = Shot(label=label, light=light, level=(1.0,), exposure_s=0.01, frames=frames)
    dn = np.random.default_rng(frames).integers(10, 20, (frames, 24, 32), dtype=np.uint8)
    return Frames(dn=dn, shot=shot, pixels="mono8", bits=8, cfa=None)


@pytest.mark.parametrize(("darks", "taken"), [(14, True), (12, True), (5, False)])
def test_darks_with_fewer_frames_than_the_rest_take_part(darks: int, taken: bool) -> None:
    """Lit shots of 23 frames could have groups of 8, and darks of 14 none: groups of 6 then. A
    fifth of the frames would cost the rest too much."""
    lit = [stack(f"lit {k}", 23, lit=True) for k in range(4)]
    dark = stack("dark", darks, lit=False)
    chosen = plan(Capture(camera="x", frames=(dark, *lit)))
    assert chosen is not None
    assert ("dark" in chosen.key) == taken
    assert chosen.frames == ({14: 6, 12: 6}.get(darks, 8))


@pytest.mark.parametrize(("repeated", "taken"), [(None, False), (5, True), (22, False)])
def test_a_shot_that_repeats_a_frame_takes_part(repeated: int | None, taken: bool) -> None:
    """Of seven shots five are looked at. A frame of another one that equals the one before makes
    that one of them, and does not if it is behind those that are looked at."""
    darks = [stack("dark", 24, lit=False)]
    lit = [stack(f"lit {k}", 24, lit=True) for k in range(6)]
    lit = [
        dataclasses.replace(
            one,
            dn=np.random.default_rng(k).integers(10, 20, (24, 24, 32), dtype=np.uint8),
            shot=dataclasses.replace(one.shot, level=((k + 1) / 6,)),
        )
        for k, one in enumerate(lit)
    ]
    shots = [*darks, *lit]
    few = [dataclasses.replace(one, dn=one.dn[:20]) for one in shots]
    without = plan(Capture(camera="x", frames=tuple(few)))
    assert without is not None
    spare = next(label for label in without.other)
    place = next(k for k, one in enumerate(shots) if one.shot.label == spare)
    if repeated is not None:
        dn = shots[place].dn.copy()
        dn[repeated] = dn[repeated - 1]
        shots[place] = dataclasses.replace(shots[place], dn=dn)
    others = [one if k == place else few[k] for k, one in enumerate(shots)]
    chosen = plan(Capture(camera="x", frames=tuple(others)))
    assert chosen is not None
    assert len(chosen.key) == len(without.key)
    assert (spare in chosen.key) is taken


@pytest.mark.parametrize(("lamps", "faintest"), [(1, True), (2, False)])
def test_of_one_lamp_the_faintest_level_takes_part(lamps: int, faintest: bool) -> None:
    """Black, a gain and a level pass through any two levels; a third one tells a bend. Two lamps
    with two darks leave no room for it."""
    darks = [stack(f"dark {k}", 24, lit=False) for k in range(3)]
    darks = [
        dataclasses.replace(one, shot=dataclasses.replace(one.shot, exposure_s=0.01 * (k + 1)))
        for k, one in enumerate(darks)
    ]
    lit = []
    for lamp in range(lamps):
        for k in range(6):
            one = stack(f"lamp {lamp}, {k}", 24, lit=True)
            shot = dataclasses.replace(one.shot, light=(f"{lamp}",), level=((k + 1) / 6,))
            lit.append(dataclasses.replace(one, shot=shot))
    chosen = plan(Capture(camera="x", frames=(*darks, *lit)))
    assert chosen is not None
    assert ("lamp 0, 0" in chosen.key) is faintest
    assert {"dark 0", "dark 2", "lamp 0, 5"} <= set(chosen.key)


def test_a_family_that_tells_nothing_has_no_chance_of_its_own() -> None:
    """Histograms of light that nobody stated have errors 10,000 times as wide as they are: twins
    have 1e-8 of chi-squared there, and a capture with 1e-6 is none the worse."""
    rng = np.random.default_rng(1)
    left = np.concatenate([rng.normal(size=40), 1e-4 * np.ones(100)])
    names = ("rows", "codes")
    spread = Spread(
        families=np.repeat(names, (40, 100)),
        alike=np.zeros(140),
        names=names,
        expected=np.array([40.0, 1e-8]),
        variance=np.array([80.0, 1e-18]),
        residuals=rng.normal(size=(24, 140)),
        amounts=np.zeros((24, 0)),
        of_body=np.zeros(0),
    )
    found = distance(left, spread)
    assert found.p_by_family["codes"] == 1.0
    assert found.p_value > 0.01


def test_a_dark_that_is_saturated_takes_no_part_unless_there_is_no_other() -> None:
    """It tells neither black level nor dark current, but that both are more than the range."""
    lit = [stack("lit", 24, lit=True)]
    darks = [stack(f"dark {k}", 24, lit=False) for k in range(3)]
    darks = [
        dataclasses.replace(one, shot=dataclasses.replace(one.shot, exposure_s=0.01 * (k + 1)))
        for k, one in enumerate(darks)
    ]
    white = [dataclasses.replace(one, dn=np.full_like(one.dn, 255)) for one in darks]
    chosen = plan(Capture(camera="x", frames=(*darks[:2], white[2], *lit)))
    assert chosen is not None
    assert chosen.key == ("dark 0", "dark 1", "lit")
    chosen = plan(Capture(camera="x", frames=(*white, *lit)))
    assert chosen is not None
    assert "dark 0" in chosen.key
