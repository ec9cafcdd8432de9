"""The choices of an effect are made by what frames tell apart, and not by what scores do."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.diagnose import diagnose
from analysis.gap.ready.setting import look
from analysis.gap.ready.spatial_denoise import filtered
from sensor.effects.demosaic import Demosaic
from sensor.effects.jpeg import Jpeg
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.effects.temporal_filter import TemporalFilter
from sensor.frames import Capture
from sensor.record import record
from tests.short import PROTOCOL, camera, light

HALVES_UP = 1.0
TONE_DN, SPACE_PX = 20.0, 0.5
PATCH_DN = 1.5

Codes = NDArray[Any]


def behind(smooth: Callable[[Codes], Codes], body: int = 8) -> Capture:
    """Whole codes of a camera as another program's filter leaves them."""
    made = camera().plus(Demosaic(arithmetic=HALVES_UP)).with_body(body)
    taken = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=body)
    frames = tuple(dataclasses.replace(shot, dn=smooth(shot.dn)) for shot in taken.frames)
    return dataclasses.replace(taken, frames=frames)


def bilateral(dn: Codes) -> Codes:
    """OpenCV's bilateral filter of 5 x 5 pixels: weights by the sum of what three colours differ
    by, exp(-1 / (2 0.5^2)) = 0.14 of the pixel's own for a straight neighbour and 0.14^2 for a
    diagonal one."""
    return np.stack([cv2.bilateralFilter(frame, 5, TONE_DN, SPACE_PX) for frame in dn])


def non_local_means(dn: Codes) -> Codes:
    """By its definition: means over 5 x 5 pixels with weights exp(-d^2 / 2 T^2), d^2 the mean
    square of what the 3 x 3 about both differ by, each colour by itself."""
    codes = dn.astype(np.float64)
    wide = np.pad(codes, ((0, 0), (2, 2), (2, 2), (0, 0)), mode="reflect")
    total, count = np.zeros((2, *codes.shape))
    height, width = codes.shape[1:3]
    for dy, dx in itertools.product(range(5), repeat=2):
        theirs = wide[:, dy : dy + height, dx : dx + width]
        unlike = ndimage.uniform_filter(np.square(theirs - codes), (0, 3, 3, 0), mode="mirror")
        weight = np.exp(-unlike / (2 * PATCH_DN**2))
        total += weight * theirs
        count += weight
    return np.asarray(np.floor(total / count + 0.5).astype(np.uint8))


def test_a_wide_filter_begins_with_its_window_and_its_kind_of_weights() -> None:
    """Of twelve beginnings the one with which twins look most like the frames has patches, five by
    five. Its gain and its threshold are no further off than steps of a fit lead back from."""
    setting = look(behind(non_local_means), {"lamp": light()})
    assert setting is not None
    told = filtered(setting)
    assert told is not None
    assert told.base is not None
    assert (told.hints["window"], told.hints["soft"]) == (3.0, 3.0)
    gains = told.base.gain_dn_per_e / camera().gain_dn_per_e.G
    assert 0.4 < gains.min() <= gains.max() < 2.5
    assert isinstance(threshold_dn := told.hints["threshold_dn"], float)
    assert PATCH_DN / 2 < threshold_dn < 2 * PATCH_DN
    plain = look(behind(lambda dn: dn), {"lamp": light()})
    assert plain is not None
    assert filtered(plain) is None


@pytest.mark.whole
def test_non_local_means_are_a_filter_in_space_by_patches() -> None:
    found = diagnose(
        behind(non_local_means), stated={"lamp": light()}, suspects=[SpatialDenoise, Jpeg]
    ).report
    (effect,) = found.effects
    assert effect.name == "spatial_denoise"
    assert (effect.parameters["window"].value, effect.parameters["soft"].value) == (3.0, 3.0)
    assert effect.parameters["threshold_dn"].value == pytest.approx(PATCH_DN, rel=0.1)


@pytest.mark.whole
def test_a_filter_that_weighs_all_colours_together_is_told_from_one_that_weighs_each() -> None:
    capture = behind(bilateral)
    found = diagnose(
        capture, stated={"lamp": light()}, suspects=[SpatialDenoise, TemporalFilter]
    ).report
    assert found.verdict == "explained"
    (effect,) = found.effects
    assert effect.name == "spatial_denoise"
    assert effect.parameters["soft"].value == 2.0
    assert effect.parameters["threshold_dn"].value == pytest.approx(TONE_DN, rel=0.1)
