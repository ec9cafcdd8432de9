"""How a camera counts, told from its frames: mosaic, arithmetic of the demosaicer, finer steps."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.look.arithmetic import (
    IN_FRACTIONS,
    OF_QUARTERS,
    OF_SIXTEENTHS,
    OF_WHOLE_SAMPLES,
    arithmetic_of,
    rules_of,
)
from analysis.gap.look.lattices import lattices_of, phase_of
from analysis.gap.look.statistics.codes import codes
from analysis.gap.look.statistics.group import Group
from sensor.demosaicers import colour_demosaicing
from sensor.frames import Capture, Frames
from sensor.protocol import Shot
from tests.mosaic import colour_capture


@pytest.mark.parametrize("cfa", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_the_mosaic_is_found_behind_colour_frames(cfa: str) -> None:
    """Measured samples have two to four times the variance of interpolated ones."""
    capture = colour_capture(cfa)
    assert phase_of(capture) == cfa
    assert sorted(lattice.channel for lattice in lattices_of(capture)) == ["B", "G", "G", "R"]


def test_no_mosaic_is_made_up() -> None:
    """Three independent channels have none."""
    dn = np.random.default_rng(5).normal(60, 4, (8, 64, 64, 3)).astype(np.uint8)
    shot = Shot(label="a", light=("lamp",), exposure_s=0.01, frames=8)
    capture = Capture(camera="x", frames=(Frames(dn=dn, shot=shot, pixels="rgb8", bits=8),))
    assert phase_of(capture) is None


FRAMES, HEIGHT, WIDTH = 8, 96, 128
HALVES = {1: lambda mean: np.floor(mean + 0.5), 2: np.round, 3: np.floor}


@pytest.mark.parametrize("step", [1, 2, 4])
def test_codes_that_a_curve_leaves_out_are_empty(step: int) -> None:
    """Steps of s codes leave s - 1 of s out, between the first that occur and the last; those of
    noise do not count, which are empty beyond."""
    rng = np.random.default_rng(step)
    dn = np.round(rng.normal(128, 12, (1, FRAMES, HEIGHT, WIDTH)) / step) * step
    share = np.square(codes(Group(codes=dn.astype(np.uint8), top_dn=255, lit=True))["empty codes"])
    assert share[0] == pytest.approx((step - 1) / step, abs=0.05)
    assert (share[0] == 0) == (step == 1)


@pytest.mark.parametrize("arithmetic", [0, *HALVES])
def test_the_arithmetic_of_a_demosaicer_is_told_from_its_frames(arithmetic: int) -> None:
    """Whole numbers with each rule for halves, and fractions; all by another program's filter."""
    fill = colour_demosaicing().demosaicing_CFA_Bayer_bilinear
    raw = np.random.default_rng(7).normal(60, 1.5, (2, 64, 64))
    if arithmetic:
        raw = np.round(raw)
    filled = np.array([fill(frame, "RGGB") for frame in raw])
    codes = HALVES.get(arithmetic, np.round)(filled).astype(np.uint8)
    shot = Shot(label="a", light=("lamp",), exposure_s=0.01, frames=2)
    frames = Frames(dn=codes, shot=shot, pixels="rgb8", bits=8, cfa="RGGB")
    capture = Capture(camera="x", frames=(frames,))
    told = arithmetic_of([codes], lattices_of(capture))
    assert told == arithmetic
    # a rule that frames keep is the camera's; halves to the even number may come of fractions
    open_ones = rules_of(told)
    assert told in open_ones
    assert (OF_WHOLE_SAMPLES in open_ones) == (told in (IN_FRACTIONS, 2))
    assert len(open_ones) == {IN_FRACTIONS: 7, 2: 2}.get(told, 1)


@pytest.mark.parametrize(("steps", "rule"), [(4, OF_QUARTERS), (16, OF_SIXTEENTHS), (None, 0)])
def test_finer_steps_are_told_by_how_wide_even_codes_are(steps: int | None, rule: int) -> None:
    """5 quarters to 3, or 17 sixteenths to 15; with the last halves up all codes are equally wide.
    A curve behind it leaves neither."""
    fill = colour_demosaicing().demosaicing_CFA_Bayer_bilinear
    rng = np.random.default_rng(9)
    light = np.linspace(20, 180, 256) + np.linspace(0, 30, 128)[:, None]
    raw = light + rng.normal(0, 1.5, (6, 128, 256))
    raw = raw if steps is None else np.round(steps * raw) / steps
    filled = np.array([fill(frame, "RGGB") for frame in raw])

    def told(codes: np.ndarray) -> int:
        shot = Shot(label="a", light=("lamp",), exposure_s=0.01, frames=6)
        frames = Frames(dn=codes.astype(np.uint8), shot=shot, pixels="rgb8", bits=8, cfa="RGGB")
        return arithmetic_of([frames.dn], lattices_of(Capture(camera="x", frames=(frames,))))

    mosaic = Frames(
        dn=np.round(raw).astype(np.uint8),
        shot=Shot(label="a", light=("lamp",), exposure_s=0.01, frames=6),
        pixels="bayer8",
        bits=8,
        cfa="RGGB",
    )
    assert arithmetic_of([mosaic.dn], lattices_of(Capture(camera="x", frames=(mosaic,)))) == rule
    assert told(np.round(filled)) == rule
    assert told(np.floor(filled + 0.5)) == IN_FRACTIONS
    bent = 255 * (filled / 255) ** 0.9
    assert told(np.round(bent)) == IN_FRACTIONS
