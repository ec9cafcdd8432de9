"""The two greens tell along which axis colours mix.

Where the upper half of a picture is red and the lower half blue, a green with a red neighbour to
the left gains eps n R by a trail along the rows after n transfers, and the other green eps n B:

    G1 - G2 = eps <n> (R - B).

What goes to all four neighbours alike gives both greens half of each, and the slope is 0.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.camera.light_blocks import light_noise
from analysis.gap.camera.twin import under_noisy_light
from analysis.gap.look.lattices import Lattice, lattices_of
from analysis.gap.look.one_group import blocks
from analysis.gap.look.statistics.greens import APART, greens
from analysis.identifiability.known import base_of, scenery_of
from sensor.camera_file import load
from sensor.effect import Effect
from sensor.effects.charge_transfer_inefficiency import ChargeTransferInefficiency
from sensor.effects.crosstalk import Crosstalk
from sensor.protocol import Protocol, Shot
from sensor.record import record
from tests.twins import twin

HEIGHT, WIDTH, SIDE = 96, 128, 5
SITES = [("R", 0, 0), ("G1", 0, 1), ("G2", 1, 0), ("B", 1, 1)]
LATTICES = tuple(Lattice(name=n, channel=n[0], dy=dy, dx=dx, step=2) for n, dy, dx in SITES)
EPS = 2e-4
BRIGHT_E, DIM_E, GREEN_E = 12_000.0, 2_000.0, 5_000.0
TRANSFERS = (WIDTH + 1) / 2
"""To a column of an image, in the mean."""


def slope_of(*effects: Effect) -> float:
    """Slope of what a camera shows of a red half over a blue half, and little noise."""
    rates = np.full((HEIGHT, WIDTH, 3), GREEN_E, dtype=np.float32)
    rates[: HEIGHT // 2, :, 0] = rates[HEIGHT // 2 :, :, 2] = BRIGHT_E
    rates[HEIGHT // 2 :, :, 0] = rates[: HEIGHT // 2, :, 2] = DIM_E
    camera = load("ideal").resized(HEIGHT, WIDTH).plus(*effects)
    shot = Shot(label="lit", light=("lamp",), exposure_s=1.0, frames=16)
    taken = record(camera, Protocol(name="one", shot=(shot,)), {"lamp": rates}, seed=1)
    lattices = lattices_of(taken)
    assert [one.name for one in lattices] == ["R", "G1", "G2", "B"]
    images = [blocks(one.of(taken.frames[0].dn).mean(axis=0), SIDE).ravel() for one in lattices]
    return float(greens(np.array(images), lattices)["greens apart by colour"])


# Each of 16 x 5 x 5 samples of a block has sqrt(5000) e-, and there are 8 x 11 blocks of colours
# 10,000 e- apart in two steps: the slope is known to
#     sqrt(2 x 5000 / 400) / sqrt(88) / 5000 = 1e-4
NOISE = 1.1e-4


def test_a_trail_along_the_rows_parts_the_greens_by_colour() -> None:
    along = ChargeTransferInefficiency(
        horizontal_per_transfer=EPS, vertical_per_transfer=0.0, beta=1.0
    )
    assert slope_of(along) == pytest.approx(EPS * TRANSFERS, abs=4 * NOISE)


def test_a_trail_down_the_columns_parts_them_the_other_way() -> None:
    """Above the green with a red neighbour beside it lies blue. The blue half is read after more
    transfers than the red one, so that the slope is not asked for its size."""
    down = ChargeTransferInefficiency(
        horizontal_per_transfer=0.0, vertical_per_transfer=EPS, beta=1.0
    )
    assert slope_of(down) < -10 * NOISE


def test_what_goes_to_all_neighbours_alike_does_not() -> None:
    """As much charge as the trail moves, and no slope."""
    assert abs(slope_of(Crosstalk(share=EPS * TRANSFERS))) < 4 * NOISE
    assert abs(slope_of()) < 4 * NOISE


def test_rows_of_green_that_differ_are_apart_whatever_the_colour() -> None:
    """offset / mean, and the slope of what lies on a line."""
    rng = np.random.default_rng(8)
    red, blue, first = rng.uniform(20, 200, (3, 50))
    second = first - 1.5 - 0.02 * (red - blue)
    found = greens(np.array([red, first, second, blue]), LATTICES)
    apart = first - second
    assert found["greens apart by colour"] == pytest.approx(0.02, rel=1e-3)
    assert found["greens apart"] == pytest.approx(apart.mean() / ((first + second) / 2).mean())


def test_a_camera_without_two_greens_has_none_of_this() -> None:
    one = Lattice(name="Y", channel="Y", dy=0, dx=0, step=1)
    assert greens(np.ones((1, 4)), (one,)) == {}


def test_the_greens_of_a_noisy_light_are_as_far_apart_as_its_paths_say() -> None:
    """Light of blocks that is known to v of its square, by so many light paths in each lattice,
    moves the mean of a green by v and the two apart by 4 v: over b even blocks the difference
    scatters by sqrt(4 v / b) of green. Any part of the noise may be there, so that the mean of
    variances is half of the whole."""
    rate = np.full((HEIGHT, WIDTH, 3), 1e4, dtype=np.float32)
    camera = load("ideal").resized(HEIGHT, WIDTH)
    shot = Shot(label="lit", light=("lamp",), exposure_s=1.0, frames=4)
    scenery = scenery_of(camera, (shot,), {"lamp": rate}, (), 2)
    noise = {"lamp": np.square(0.05 * rate)}
    light = dataclasses.replace(scenery.light, noise=noise)
    scenery = dataclasses.replace(scenery, light=light)
    base = base_of(camera, ("lamp",))
    quiet = dataclasses.replace(scenery, light=dataclasses.replace(light, noise={}))
    plain = twin(quiet, base, seed=3)
    bodies = [under_noisy_light(plain, scenery, base, body) for body in range(400)]
    place = next(k for k, key in enumerate(plain.keys) if key.statistic == APART)
    apart = np.array([one.figures[0, place] - plain.figures[0, place] for one in bodies])
    moved = np.array([one.means[0, 0, 1] / plain.means[0, 0, 1] - 1 for one in bodies])
    v = light_noise(light, scenery.view, plain.channels)["lamp"][1]
    part = 1 / 2
    assert np.square(moved).mean() == pytest.approx(part * v.mean(), rel=5 * 0.3 / np.sqrt(400))
    expected = part * 4 * v.mean() / len(v)
    assert np.square(apart).mean() == pytest.approx(expected, rel=5 * np.sqrt(2.5 / 400))
