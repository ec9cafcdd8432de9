"""A curve behind the converter is told by how brightness goes with the exposure, without a comb.

Of rates F on photosites and exposures T the codes are c(o + F T), and behind the inverse of c they
are as T again. Of a power g about code 0 logarithms of rates that are read in front of that differ
by about (g - 1) ln(T / T') and more, the less light there is over black.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.look.curve import powered
from analysis.gap.ready.gamma import EXPONENTS, bent
from analysis.gap.ready.setting import Setting, look
from sensor.effects.nonlinearity import Nonlinearity
from sensor.frames import Capture
from sensor.protocol import Protocol, Shot
from sensor.record import record
from tests.short import camera, light

FINER = 16
"""Steps of the converter in a code that leaves the camera."""

PROTOCOL = Protocol(
    name="exposures",
    shot=(
        Shot(label="dark", exposure_s=0.02, frames=16),
        *(
            Shot(label=f"{1e3 * t:g} ms", light=("lamp",), level=(1.0,), exposure_s=t, frames=16)
            for t in (0.008, 0.013, 0.02)
        ),
    ),
)


def through(exponent: float, about_black: bool) -> Setting:
    """A capture whose values go through a power before they are rounded: of codes that have been
    spread over a sixteenth of a step on either side, as those of a finer converter are."""
    made = camera()
    capture = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)
    top = float(capture.frames[0].top_dn)
    origin = made.black_dn if about_black else 0.0
    rng = np.random.default_rng(6)
    frames = []
    for one in capture.frames:
        finer = np.round((one.dn + rng.uniform(-0.5, 0.5, one.dn.shape)) * FINER) / FINER
        codes = np.clip(np.round(powered(finer, top, origin, exponent)), 0, top)
        frames.append(dataclasses.replace(one, dn=codes.astype(np.uint8)))
    setting = look(dataclasses.replace(capture, frames=tuple(frames)), {"lamp": light()})
    assert setting is not None
    return setting


def taken(brightness: float, shots: slice) -> Setting:
    """Some shots of that camera under more or less light."""
    capture = record(camera(), PROTOCOL, {"lamp": light().rate_e_per_s * brightness}, seed=5)
    setting = look(Capture(camera="some", frames=capture.frames[shots]), {"lamp": light()})
    assert setting is not None
    return setting


@pytest.mark.parametrize("exponent", [0.6, 0.8, 1.3])
@pytest.mark.parametrize("about_black", [False, True])
def test_a_power_is_told_to_the_grid_of_exponents(exponent: float, about_black: bool) -> None:
    """Where the curve begins is told as well: what is black stays where it was, or does not. Noise
    that is bent near black moves means there, by which the exponent is off by two steps at most."""
    told = bent(through(exponent, about_black))
    assert told is not None
    step = float(np.diff(EXPONENTS[:2])[0])
    assert told.hints["exponent"] == pytest.approx(exponent, abs=3.01 * step)
    assert told.hints["about_black"] == float(about_black)
    assert not told.exact


def test_what_goes_as_the_exposure_has_no_curve() -> None:
    assert bent(through(1.0, about_black=False)) is None


@pytest.mark.parametrize(
    ("brightness", "shots"),
    [(1.0, slice(1, None)), (1.0, slice(0, 2)), (0.01, slice(None))],
    ids=["no dark", "one exposure", "nothing is lit"],
)
def test_where_exposures_say_nothing_nothing_is_told(brightness: float, shots: slice) -> None:
    assert bent(taken(brightness, shots)) is None


def test_what_bends_light_and_not_codes_is_no_power() -> None:
    """A quadratic term of 5 % of the full well bends bright blocks alone, and no power makes that
    straight again where blocks are dim."""
    made = camera().plus(Nonlinearity(quadratic_ratio=0.05, cubic_ratio=0.0))
    capture = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)
    setting = look(capture, {"lamp": light()})
    assert setting is not None
    assert bent(setting) is None
