"""Steps of a calibration: which of two cameras is the better one, and where a step leads."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.calibrate.calibration import Calibration
from analysis.gap.calibrate.nuisance import Directions, Knob
from analysis.gap.calibrate.refine import BY_MOMENTS, Refined, better
from analysis.gap.calibrate.space import Space
from analysis.gap.calibrate.turning import tune, turn
from analysis.gap.camera.handles import Handle
from analysis.gap.look.observation import Key
from sensor.colours import Colours
from sensor.effects.ambient_light import AmbientLight
from tests.candidates import BASE

BLOCKS, FIGURES = 200, 50
KEYS = tuple(
    Key(shot="dark", lattice="G", family="pattern", statistic=str(k)) for k in range(FIGURES)
)


def camera(blocks_off_dn: float, width_dn: float, figures_off: float) -> Refined:
    """A camera that is off by so much in every block and, in standard errors, in every figure."""
    space = Space(
        keys=KEYS, expected_figures=np.zeros(FIGURES),
        expected_means=np.zeros((1, 1, BLOCKS)), spread=np.ones(FIGURES),
        whitening=np.full((1, BLOCKS, 1, 1), 1 / width_dn), shape=(1, 1, BLOCKS),
    )  # fmt: skip
    count = FIGURES + BLOCKS
    nothing_taken_up = Calibration(
        space=space, q=np.zeros((count, 1)), solve=np.zeros((1, 1)), priors=np.zeros(1)
    )
    base: Any = SimpleNamespace()
    gap = space.vector(np.full(FIGURES, figures_off), np.full((1, 1, BLOCKS), blocks_off_dn))
    return Refined(
        base=base, effects=(), bodies={}, light=nothing_taken_up, gap=gap, expected=float(count)
    )


@pytest.mark.parametrize(
    ("what", "one", "than", "taken"),
    [
        ("twice the width, as far off: 2 ln 2 - 3/4 a block is lost",
         camera(1.0, 2.0, 1.0), camera(1.0, 1.0, 1.0), False),
        ("half the width, as far off: 2 ln 2 is won, 3 lost",
         camera(1.0, 0.5, 1.0), camera(1.0, 1.0, 1.0), False),
        ("nearer by its own errors and likelier",
         camera(0.5, 1.0, 1.0), camera(1.0, 1.0, 1.0), True),
        ("wider, so less likely, but it fits, and its figures are nearer",
         camera(1.0, 2.0, 0.9), camera(1.0, 1.0, 1.2), True),
        ("the same where it does not fit",
         camera(2.4, 2.0, 0.9), camera(1.2, 1.0, 1.2), False),
        ("wider, and figures that are farther: too much fixed pattern",
         camera(1.0, 2.0, 1.3), camera(1.0, 1.0, 1.2), False),
    ],
)  # fmt: skip
def test_the_better_of_two_cameras(what: str, one: Refined, than: Refined, taken: bool) -> None:
    """n blocks that are off by d with a width w have a deviance of n (d^2 / w^2 + 2 ln w)."""
    assert better(one, than) is taken, what


def test_a_gain_steps_with_what_gathers_in_darks_along_their_hyperbola() -> None:
    """Darks tell k r, of a gain k and a rate r, to a thousandth. By a step of g = d ln k and d of r
    it becomes k r (1 + g) + k d, where a straight step of both gives k e^g (r + d): 5 % less with
    g = 0.3 and d = -g r."""
    k, r = np.array([0.05, 0.04, 0.03]), np.array([2e5, 1.5e5, 1e5])
    g = np.array([0.3, -0.2, 0.1])
    d = -g * r
    base = dataclasses.replace(BASE, channels=("R", "G", "B"), gain_dn_per_e=k, level={})
    light = AmbientLight(rate_e_per_s=Colours(R=r[0], G=r[1], B=r[2]))
    ways = directions(
        tuple(Knob(name="gain", channel=c, step=0.15) for c in range(3)),
        tuple(Handle(effect=light.name, parameter="rate_e_per_s", channel=c) for c in range(3)),
    )
    amounts = np.concatenate([g, d])
    lit = tune(light, ways, amounts)
    assert isinstance(lit, AmbientLight)
    rates = np.array([Colours.of(lit.rate_e_per_s)[c] for c in base.channels])
    now = turn(base, ways, amounts).gain_dn_per_e * rates
    np.testing.assert_allclose(now, k * r * (1 + g) + k * d, rtol=1e-9)


def test_a_dark_current_steps_with_the_gain_of_one_channel() -> None:
    base = dataclasses.replace(BASE, gain_dn_per_e=np.array([0.05]), shown_e_per_s=1e5)
    ways = directions(
        (Knob(name="gain", channel=0, step=0.15), Knob(name="shown", channel=None, step=1.0))
    )
    now = turn(base, ways, np.array([0.3, -2e4]))
    promised = 0.05 * 1e5 * 1.3 - 0.05 * 2e4
    assert float(now.gain_dn_per_e[0]) * now.shown_e_per_s == pytest.approx(promised, rel=1e-9)


def test_a_clamp_stays_where_moments_have_put_it() -> None:
    ways = directions((Knob(name="clamp", channel=None, step=1.0),))
    put = 0.5 * BASE.most_of_a_clamp_e2
    base = dataclasses.replace(BASE, clamp_e2=put)
    assert turn(base, ways, np.array([-0.2 * put])).clamp_e2 == pytest.approx(0.8 * put)
    assert turn(base, ways, np.array([-0.2 * put]), still=BY_MOMENTS).clamp_e2 == put


def directions(knobs: tuple[Knob, ...], tuned: tuple[Handle, ...] = ()) -> Directions:
    """Of which nothing but the names is asked."""
    nothing = np.zeros(0)
    return Directions(knobs=knobs, tuned=tuned, figures=nothing, means=nothing, prior=nothing)
