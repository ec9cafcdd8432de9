"""A patch of light is found by what calibration leaves of it, not by where that is brightest.

If what is left of the capture is that of a lobe, r = (1 - Q Q') v, the gain of a trial lobe with
v' is |r'.r|^2 / |r'|^2, which Cauchy and Schwarz bound by |r|^2: only the lobe itself reaches it.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from analysis.gap.calibrate.fit import around
from analysis.gap.look.lattices import BORDER_PX
from analysis.gap.measure.case import Case
from analysis.gap.measure.measured import measured
from analysis.gap.measure.signature import signature
from analysis.gap.ready.setting import look
from analysis.gap.suspects.lobe import FINER, SIZES, lobe_of
from analysis.identifiability.known import base_of
from sensor.effects.specular_glare import SpecularGlare
from sensor.record import record
from tests.short import PROTOCOL, camera, light

PLACES = [(0.71, 0.29, 0.3), (0.25, 0.6, 0.25), (0.5, 0.5, 0.12), (0.8, 0.8, 0.08)]
"""Across, below, standard deviation: parts of the width, of the height, of the height."""


@functools.cache
def plain() -> Case:
    """A capture against its own camera."""
    setting = look(
        record(camera().with_body(3), PROTOCOL, {"lamp": light().rate_e_per_s}, seed=3),
        {"lamp": light()},
    )
    assert setting is not None
    known = around(base_of(camera(), ["lamp"]), setting.scenery)
    return measured(known, setting.seen).case


def with_a_patch(
    across: float, below: float, sigma: float, longer: float = 1.0, slant_deg: float = 0.0
) -> Case:
    """The same, with nothing left but what a patch of light leaves."""
    case = plain()
    glare = SpecularGlare(
        strength=0.1,
        across=across,
        below=below,
        sigma_px=sigma * case.known.scenery.body.height,
        longer=longer,
        slant_deg=slant_deg,
    )
    shown = signature(glare, case.known)
    assert shown is not None
    turned = case.fitting.turned
    figures = np.zeros(len(shown.keys))
    return dataclasses.replace(
        case, fit_left=turned.left(turned.space.vector(figures, shown.means))
    )


@pytest.mark.parametrize(("across", "below", "sigma"), PLACES)
def test_a_patch_is_found_where_it_lies(across: float, below: float, sigma: float) -> None:
    """To one step of the search, a part of a block in place and a factor in size; a wide one to a
    sixth of its size, as slopes and tints of the light take up what tells its place."""
    case = with_a_patch(across, below, sigma)
    body, view = case.known.scenery.body, case.known.scenery.view
    block_px = view.side * view.lattices[0].step
    found = lobe_of(case)
    assert found is not None
    near_px = max(block_px / FINER, found.sigma_px / 6)
    assert abs(found.x_px - across * body.width) <= near_px
    assert abs(found.y_px - below * body.height) <= near_px
    factor = (body.height / block_px) ** (1 / (SIZES - 1))
    assert sigma / factor <= found.sigma_px / body.height <= sigma * factor


@pytest.mark.parametrize(("longer", "slant_deg"), [(2.0, 30.0), (3.0, -70.0), (1.0, 0.0)])
def test_a_patch_that_is_longer_than_wide_is_told_with_its_slant(
    longer: float, slant_deg: float
) -> None:
    """As bright as is seen at n = 50 standard errors, with noise. Both axes of such a lobe are
    known to 1 / n, so that ln l is to sqrt(2) / n and twice its slant to as much over ln l, and to
    twice that where calibration hides three quarters of what tells it. Five of these for four
    seeds."""
    case = with_a_patch(0.6, 0.45, 0.16, longer, slant_deg)
    space, turned = case.fitting.turned.space, case.fitting.turned
    size, n = len(space.keys) + int(np.prod(space.shape)), 50.0
    alone = n * case.fit_left / np.linalg.norm(case.fit_left)
    for seed in range(4):
        noise = np.random.default_rng(seed).standard_normal(size)
        found = lobe_of(dataclasses.replace(case, fit_left=alone + turned.left(noise)))
        assert found is not None
        if longer == 1.0:
            assert (found.longer, found.slant_deg) == (1.0, 0.0)
            continue
        off = 5 * 2 * np.sqrt(2) / n
        assert np.log(found.longer / longer) == pytest.approx(0.0, abs=off)
        turn = (found.slant_deg - slant_deg + 90) % 180 - 90
        assert turn == pytest.approx(0.0, abs=np.degrees(off / np.log(longer)) / 2)


SCORE = 300.0
"""Of the patches below, in chi-squared."""


def test_noise_leads_less_astray_than_from_the_brightest_block() -> None:
    """A lobe of n standard errors has its place to about sigma / n, times what calibration hides;
    the brightest block of what is left of it is brightest by its own noise."""
    far, by_the_brightest = [], []
    for place in PLACES:
        case = with_a_patch(*place)
        across, below, sigma = place
        space, body = case.fitting.turned.space, case.known.scenery.body
        view = case.known.scenery.view
        middle, scale = (across * body.width, below * body.height), sigma * body.height
        alone = np.sqrt(SCORE) * case.fit_left / np.linalg.norm(case.fit_left)
        size = len(space.keys) + int(np.prod(space.shape))
        for seed in range(8):
            noise = np.random.default_rng(seed).standard_normal(size)
            left = alone + case.fitting.turned.left(noise)
            found = lobe_of(dataclasses.replace(case, fit_left=left))
            assert found is not None
            far.append(np.hypot(found.x_px - middle[0], found.y_px - middle[1]) / scale)
            image = left[len(space.keys) : size].reshape(space.shape).mean(axis=(0, 1))
            y, x = divmod(int(image.argmax()), case.fit_seen.grid[1])
            block_px = view.side * view.lattices[0].step
            at = (BORDER_PX + (k + 0.5) * block_px for k in (x, y))
            off = np.subtract(tuple(at), middle)
            by_the_brightest.append(np.hypot(*off) / scale)
    assert max(far) < 0.6
    assert np.mean(far) < np.mean(by_the_brightest) / 2


def test_the_best_place_of_noise_is_no_place() -> None:
    """The best of 7,000 places and sizes that overlap is as good as the best of a few hundred."""
    turned = plain().fitting.turned
    size = len(turned.space.keys) + int(np.prod(turned.space.shape))
    for seed in range(40):
        noise = np.random.default_rng(100 + seed).standard_normal(size)
        assert lobe_of(dataclasses.replace(plain(), fit_left=turned.left(noise))) is None
