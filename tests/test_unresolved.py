"""Light between pixels: what smooth light and hard edges would show there."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.measure.signature import starts
from analysis.gap.suspects.beginnings import chosen_otherwise
from foundation.backend import backend
from sensor.effects.lateral_chromatic_aberration import LateralChromaticAberration
from sensor.effects.lens_distortion import LensDistortion
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import exposed, lit
from sensor.unresolved import OF_HARD_EDGES
from tests.effects_bench import EXPOSURE_S, Array, bench_camera, rate_of
from tests.harness import assert_agree

HEIGHT, WIDTH = 48, 64
CORNER_PX = np.hypot(HEIGHT, WIDTH) / 2
RED_PX = 0.6


def weights(t: Array) -> tuple[Array, Array]:
    """Of the four samples about a place, (4, ...): by Keys, and by a straight line."""
    cubic = [
        -t * (1 - t) ** 2 / 2,
        (3 * t**3 - 5 * t**2 + 2) / 2,
        t * (1 + 4 * t - 3 * t**2) / 2,
        t**2 * (t - 1) / 2,
    ]
    return np.array(cubic), np.array([0 * t, 1 - t, t, 0 * t])


def test_a_cubic_is_so_far_from_hard_edges_as_is_stated() -> None:
    """Of an edge at any place p of a pixel and a move by any t: the mean over a pixel is the
    integral of a step, in closed form."""
    middles = (np.arange(100) + 0.5) / 100
    p, t = np.meshgrid(middles, middles, indexing="ij")
    pixels = np.arange(-4, 5)[:, None, None]

    def seen(shift: Array | float) -> Array:
        """Means of pixels right of so much, of which each ends at a whole number."""
        return np.clip(pixels + 1 - p + shift, 0.0, 1.0)

    truth, still = seen(t)[1:-2], seen(0.0)
    cubic, line = (sum(w[k] * still[k : k + len(truth)] for k in range(4)) for w in weights(t))
    ratio = np.sqrt(np.square(truth - cubic).sum() / np.square(line - cubic).sum())
    assert ratio == pytest.approx(OF_HARD_EDGES, rel=0.005)


def seen_in_red(scene: Array, unresolved: float, body: int = 0) -> Array:
    """Red light in electrons, magnified by so much."""
    effect = LateralChromaticAberration(red_px=RED_PX, blue_px=0.0, unresolved=unresolved)
    camera = bench_camera(effect, height=HEIGHT, width=WIDTH).with_body(body)
    shot = Shot(label="one", light=("lamp",), level=(1.0,), exposure_s=EXPOSURE_S, frames=1)
    light = lit(camera, shot, {"lamp": rate_of(scene)}, backend())
    rate = exposed(camera, light, range(1), seed=1, until=Quantity.RATE)
    return np.asarray(rate.value.numpy())[0, ..., 0] * EXPOSURE_S


def test_bodies_scatter_beside_an_edge_as_hard_edges_do_and_nowhere_else() -> None:
    """By 2.13 u times what a line shows beyond a cubic, u even from 0 to 1: of the product with a
    normal number the mean square is a third, and the mean fourth power 27/5 of that squared."""
    x = np.arange(WIDTH)
    edge = np.broadcast_to(np.where(x < WIDTH - 8, 6000.0, 1000.0), (HEIGHT, WIDTH))
    still = seen_in_red(edge, 0.0)
    bodies = 200
    off = np.array([seen_in_red(edge, 1.0, body) - still for body in range(bodies)])
    # rows are alike but for their own places in pixels, of which an edge down the picture has none
    assert np.abs(off - off[:, :1]).max() < 0.01
    middle = (WIDTH - 1) / 2
    place = middle + (x - middle) / (1 + RED_PX / CORNER_PX)
    first = np.floor(place).astype(int)
    samples = np.array([edge[0][np.clip(first + k, 0, WIDTH - 1)] for k in (-1, 0, 1, 2)])
    cubic, line = ((w * samples).sum(axis=0) for w in weights(place - first))
    expected = OF_HARD_EDGES * (line - cubic)
    beside = np.abs(expected) > 20.0
    assert 2 <= beside.sum() <= 4
    variance = off[:, 0, beside].var(axis=0)
    third = np.square(expected[beside]) / 3
    assert_agree(variance, third, third * np.sqrt((27 / 5 - 1) / bodies), "beside the edge")
    assert np.abs(off[:, 0, expected == 0]).max() < 0.01


def test_of_a_ramp_nothing_is_unresolved() -> None:
    """A line between its pixels is a line."""
    ramp = np.broadcast_to(1000.0 + 40.0 * np.arange(WIDTH), (HEIGHT, WIDTH))
    inside = np.s_[:, 4:-4]
    smooth, hard = (seen_in_red(ramp, part, body=3)[inside] for part in (0.0, 1.0))
    assert np.allclose(smooth, hard, rtol=1e-5)


def test_a_search_begins_with_smooth_light_and_may_choose_edges() -> None:
    """Where that leaves less; see `analysis.gap.search.confirm`."""
    for kind in (LensDistortion, LateralChromaticAberration):
        assert {one.values()["unresolved"] for one in starts(kind)} == {0.0}
        (other,) = chosen_otherwise(kind())
        assert other == dataclasses.replace(kind(), unresolved=1.0)
