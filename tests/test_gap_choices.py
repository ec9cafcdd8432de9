"""The choices of an effect are made by what frames tell apart, and not by what scores do."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from sensor.effects.demosaic import Demosaic
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.effects.temporal_filter import TemporalFilter
from sensor.record import record
from tests.short import PROTOCOL, camera, light

HALVES_UP = 1.0
TONE_DN, SPACE_PX = 20.0, 0.5


@pytest.mark.whole
def test_a_filter_that_weighs_all_colours_together_is_told_from_one_that_weighs_each() -> None:
    """OpenCV's bilateral filter of 5 x 5 pixels: weights by the sum of what three colours differ
    by, exp(-1 / (2 0.5^2)) = 0.14 of the pixel's own for a straight neighbour and 0.14^2 for a
    diagonal one, on whole codes."""
    made = camera().plus(Demosaic(arithmetic=HALVES_UP)).with_body(8)
    taken = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=8)
    frames = tuple(
        dataclasses.replace(
            shot,
            dn=np.stack([cv2.bilateralFilter(dn, 5, TONE_DN, SPACE_PX) for dn in shot.dn]),
        )
        for shot in taken.frames
    )
    capture = dataclasses.replace(taken, frames=frames)
    found = diagnose(
        capture, stated={"lamp": light()}, suspects=[SpatialDenoise, TemporalFilter]
    ).report
    assert found.verdict == "explained"
    (effect,) = found.effects
    assert effect.name == "spatial_denoise"
    assert effect.parameters["soft"].value == 2.0
    assert effect.parameters["threshold_dn"].value == pytest.approx(TONE_DN, rel=0.1)
