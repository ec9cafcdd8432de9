"""The light of a capture that names no scene: a surface through pictures that are even."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.camera.light import light_of
from analysis.gap.camera.light_of_frames import light_shown, without_pattern
from analysis.gap.camera.surface import EVEN, SHAPES, laid, surface_of
from sensor.frames import Capture, Frames
from sensor.protocol import Shot

HEIGHT, WIDTH = 120, 160
DOWN, ACROSS = (np.mgrid[:HEIGHT, :WIDTH] - np.array([59.5, 79.5])[:, None, None]) / 60.0


def shaded(field_deg: float) -> NDArray[np.float32]:
    """Light that a lens darkens to its corners at such an angle, from a lamp at one side."""
    slope2 = np.tan(np.radians(field_deg)) ** 2 * (DOWN**2 + ACROSS**2) / (1 + (4 / 3) ** 2)
    light = (1 + 0.05 * ACROSS - 0.03 * DOWN) / (1 + slope2) ** 2
    return np.repeat(light[..., None], 3, axis=2).astype(np.float32)


def dust(depth: float) -> NDArray[np.float32]:
    """What a grain of four pixels leaves of the light."""
    away2 = ((DOWN - 0.3) ** 2 + (ACROSS - 0.5) ** 2) / (4 / 60) ** 2
    return (1 - depth * np.exp(-(away2**2)))[..., None].astype(np.float32)


@pytest.mark.parametrize("field_deg", [10.0, 30.0, 38.0])
def test_a_surface_is_what_lens_and_lamp_make_and_not_the_dust(field_deg: float) -> None:
    light = shaded(field_deg)
    found = surface_of(light)
    assert found is not None
    np.testing.assert_allclose(found, light, rtol=1e-3)
    through = surface_of(light * dust(0.05))
    assert through is not None
    left = (light * dust(0.05) / through).min()
    assert left == pytest.approx(0.95, abs=0.005)


def test_shapes_are_a_polynomial_and_what_lenses_do_beside_it() -> None:
    """28 products of the sixth degree, and powers of the distance that is 1 in the corners, also
    about an axis that is not in the middle. Each of these is laid as it is written, but for what
    the products do: all that it has of a level is theirs."""
    assert SHAPES == 28 + 6
    y, x = np.linspace(-1, 1, HEIGHT)[:, None], np.linspace(-1, 1, WIDTH)[None]
    r2 = (HEIGHT**2 * y**2 + WIDTH**2 * x**2) / (HEIGHT**2 + WIDTH**2)
    wanted = (r2**4, r2**5, y * r2**3, x * r2**3, y * r2**4, x * r2**4)
    made = laid(np.eye(SHAPES), (HEIGHT, WIDTH)).reshape(-1, SHAPES)
    products, lenses = made[:, :28], made[:, 28:]
    written = np.array([one.ravel() for one in wanted]).T
    theirs = products @ np.linalg.lstsq(products, written - lenses, rcond=None)[0]
    np.testing.assert_allclose(written, lenses + theirs, atol=1e-12)
    assert np.abs(lenses.mean(axis=0)).max() < 0.03 * np.abs(lenses).max()
    bent = np.repeat((2 + ((1 + x + y) / 3) ** 6)[..., None], 3, axis=2).astype(np.float32)
    found = surface_of(bent)
    assert found is not None
    np.testing.assert_allclose(found, bent, rtol=1e-5)


def test_a_picture_with_an_edge_is_not_even() -> None:
    """Half of a step is left in a strip as wide as the shortest wave of a surface."""
    half = np.where(ACROSS > 0, 1.0, 0.0)[..., None].astype(np.float32)
    light = shaded(10.0)
    assert surface_of(light * (1 + EVEN * half)) is not None
    assert surface_of(light * (1 + 20 * EVEN * half)) is None
    assert surface_of(light * np.array([1.0, 1.0, 0.0], np.float32)) is None


@pytest.mark.parametrize("cfa", [None, "GRBG"])
@pytest.mark.parametrize("patch", [0.0, 0.5])
def test_pictures_that_are_even_are_judged_and_others_not(patch: float, cfa: str | None) -> None:
    """The surface has the frames' own units: no camera file may be built on it. It is right to a
    hundredth in the corners, too, where a mosaic ends."""
    level = 1000.0 * shaded(20.0)[..., 0].astype(np.float64)
    level[30:60, 40:90] *= 1 - patch
    draw = np.random.default_rng(3)

    def frames(label: str, mean: NDArray[np.float64], lamp: str) -> Frames:
        dn = np.round(draw.normal(100.0 + mean, 5.0, (4, HEIGHT, WIDTH))).astype(np.uint16)
        shot = Shot(label=label, light=(lamp,), exposure_s=0.5, frames=4)
        return Frames(dn=dn, shot=shot, pixels="bayer16" if cfa else "mono16", bits=12, cfa=cfa)

    shots = (frames("dark", 0 * level, "none"), frames("flat", level, "sphere"))
    found = light_of(Capture(camera="flats", frames=shots), {}, 100.0)
    assert found.known == (patch == 0)
    assert not found.in_electrons
    if found.known:
        rates = np.repeat(2 * level[..., None], 3, axis=2)
        np.testing.assert_allclose(found.rates["sphere"], rates, rtol=0.01)


def test_a_picture_that_is_clipped_is_read_where_it_is_not() -> None:
    """A patch that is full in one of two shots, and one that is full in both: the first is as
    bright as the other shot has it, of the second nothing more is known. What is filled in from
    clipped neighbours is not believed either."""
    light = np.full((HEIGHT, WIDTH), 1000.0)
    light[30:60, 40:90], light[80:100, 20:60] = 5000.0, 12000.0

    def frames(unit: float) -> Frames:
        dn = np.clip(np.round(100.0 + unit * light), 0, 4095).astype(np.uint16)[None].repeat(4, 0)
        shot = Shot(label=f"{unit:g}", light=("sphere",), exposure_s=unit, frames=4)
        return Frames(dn=dn, shot=shot, pixels="bayer16", bits=12, cfa="RGGB")

    found = light_shown([(unit, frames(unit)) for unit in (0.5, 1.0)], 100.0)
    wanted = np.where(light > 6000, (4095 - 100) / 0.5, light)
    inside = ndimage.binary_erosion(light == 1000.0, iterations=3) | (light > 1000)
    inside = ndimage.binary_erosion(inside, iterations=2)
    assert found[inside] == pytest.approx(wanted[inside][:, None].repeat(3, axis=1), rel=1e-6)


def test_the_pattern_of_photosites_goes_and_edges_stay() -> None:
    """A response that differs by 1 %, and an edge of half the light: of the pattern a fifth is
    left, as of a mean of 25, and a little of what varies more by chance; the edge stays, with what
    is on it."""
    noise = 0.01 * np.random.default_rng(8).standard_normal((HEIGHT, WIDTH, 3))
    light = np.where(ACROSS > 0, 1000.0, 500.0)[..., None].repeat(3, axis=2)
    found = without_pattern((light * (1 + noise)).astype(np.float32)) / light - 1
    away = np.abs(ACROSS) > 3 / 60
    assert 0.19 < found[away].std() / 0.01 < 0.25
    assert found[~away].std() < 0.015
    beside = np.abs(ACROSS) < 2 / 60
    assert found[beside] == pytest.approx(noise[beside], abs=0.004)


def test_light_is_read_from_the_shots_that_show_it() -> None:
    """The line through black that is nearest to all shots: a slope of fixed offsets o is a light of
    o sum(u) / sum(u^2), where a mean of what each shot shows in its unit u had ten times of it."""
    light, offsets = 1000.0 * shaded(20.0)[..., 0].astype(np.float64), 5.0 * ACROSS
    units = np.array([0.05, 1.0])

    def frames(unit: float) -> Frames:
        mean = 100.0 + unit * light + offsets
        shot = Shot(label=f"{unit:g}", light=("sphere",), exposure_s=unit, frames=4)
        dn = np.round(np.repeat(mean[None], 4, axis=0)).astype(np.uint16)
        return Frames(dn=dn, shot=shot, pixels="mono16", bits=12)

    found = light_of(Capture(camera="flats", frames=tuple(map(frames, units))), {}, 100.0)
    too_bright = offsets * units.sum() / np.square(units).sum()
    assert found.drawn
    assert found.rates["sphere"][..., 1] - light == pytest.approx(too_bright, abs=0.5)
