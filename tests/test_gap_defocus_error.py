"""A picture is as soft as a disc makes it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.ready.defocus_error import soft
from sensor.effects.defocus_error import disc
from tests.candidates import BASE


@pytest.mark.parametrize("diameter_px", [2.0, 3.7, 9.0])
def test_the_disc_has_the_variance_of_the_blur(diameter_px: float) -> None:
    """Second moment of the weights of a disc along each axis: D^2 / 16, to a hundredth of it."""
    weights = disc(diameter_px)
    place = np.arange(len(weights)) - len(weights) // 2
    for axis in (0, 1):
        variance_px2 = float(weights.sum(axis=axis) @ np.square(place))
        told = soft(dataclasses.replace(BASE, blur_px2=variance_px2))
        assert told is not None
        assert told.hints["diameter_px"] == pytest.approx(diameter_px, rel=0.005)
        assert told.base is not None
        assert told.base.blur_px2 == 0.0
        assert not told.exact


def test_a_sharp_picture_tells_of_no_disc() -> None:
    assert soft(dataclasses.replace(BASE, blur_px2=0.1)) is None
    assert soft(BASE) is None
