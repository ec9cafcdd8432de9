"""Effects from elsewhere: each does what it says, less where it is weaker; none imports ours."""

from __future__ import annotations

import ast
import dataclasses
from pathlib import Path

import numpy as np
import pytest

from camtruth.blind.foreign import library, strange_charge, strange_light, strange_signal
from camtruth.blind.foreign.outsider import About, Outsider
from sensor.catalogue import catalogue

HEIGHT, WIDTH, FRAMES = 32, 48, 4
ABOUT = About(
    shot="lit",
    lamps=("incandescent",),
    exposure_s=0.03,
    frames=tuple(range(FRAMES)),
    cfa="RGGB",
    bits=8,
    black_dn=3.0,
    seed=1,
    body_seed=2,
)
FOLDER = Path(library.__file__).parent
LEAST_STRANGE = 12
OURS = {"foundation", "scenes", "render", "sensor", "analysis"}


def given(place: str) -> np.ndarray:  # type: ignore[type-arg]
    """A smooth ramp with noise, in the quantity of a place."""
    rng = np.random.default_rng(5)
    x = np.linspace(0.2, 1.0, WIDTH)[None, None] * np.linspace(0.5, 1.0, HEIGHT)[None, :, None]
    ramp = np.broadcast_to(x, (FRAMES, HEIGHT, WIDTH))
    if place == "electrons":
        return rng.poisson(4000 * ramp).astype(np.float32)
    if place == "rate":
        return np.asarray(2e5 * ramp[..., None] * np.array([1.0, 0.8, 0.6]), dtype=np.float32)
    if place in ("mosaic", "demosaic"):
        return (200 * ramp + rng.normal(0, 2, ramp.shape)).astype(np.float32)
    image = 200 * ramp[..., None] * np.array([1.0, 0.8, 0.6])
    image = image + rng.normal(0, 2, image.shape)
    return (np.round(image) if place == "codes" else image).astype(np.float32)


ALL = list(library.outsiders().values())
STRANGE = [o for o in ALL if o.source == "none"]


def named(outsider: Outsider) -> str:
    return outsider.name


def test_at_least_twelve_are_in_no_catalogue() -> None:
    assert len(STRANGE) >= LEAST_STRANGE
    assert not {o.name for o in STRANGE} & set(catalogue())
    assert all(not o.answers for o in STRANGE)


def test_other_peoples_code_answers_to_names_of_the_catalogue() -> None:
    for outsider in ALL:
        assert set(outsider.answers) <= set(catalogue()), outsider.name
        assert bool(outsider.answers) == (outsider.source != "none")


def test_a_library_is_either_here_or_said_to_be_missing() -> None:
    here = {o.source for o in ALL} - {"none"}
    assert here | set(library.missing()) == set(library.OTHERS)
    assert not here & set(library.missing())
    assert {"opencv", "colour-demosaicing", "libjpeg"} <= here


def test_nothing_of_ours_is_imported_there() -> None:
    for file in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not {name.split(".")[0] for name in names} & OURS, file.name


@pytest.mark.parametrize("outsider", ALL, ids=named)
def test_it_changes_what_it_is_given_and_keeps_its_argument(outsider: Outsider) -> None:
    before = given(outsider.place)
    kept = before.copy()
    after = np.asarray(outsider.act(before, outsider.strongest, ABOUT))
    np.testing.assert_array_equal(before, kept)
    assert after.shape == ((*before.shape, 3) if outsider.place == "demosaic" else before.shape)
    assert np.isfinite(after).all()
    if outsider.place != "demosaic":
        assert np.abs(after - before).max() > 0
    again = np.asarray(outsider.act(before, outsider.strongest, ABOUT))
    np.testing.assert_array_equal(after, again)


@pytest.mark.parametrize(
    "outsider", [o for o in ALL if not o.choice and o.place != "codes"], ids=named
)
def test_it_is_weaker_where_its_strength_is_smaller(outsider: Outsider) -> None:
    before = given(outsider.place)
    weak, strong = (
        float(np.mean((np.asarray(outsider.act(before, s, ABOUT)) - before) ** 2))
        for s in (outsider.weakest, outsider.strongest)
    )
    assert weak < strong


def test_glow_adds_what_it_says_in_the_corner() -> None:
    """A Poisson count of mean strength x exposure there: 5 standard errors over the frames."""
    dark = np.zeros((FRAMES, HEIGHT, WIDTH), dtype=np.float32)
    glow = strange_charge.amplifier_glow(dark, 1e6, ABOUT)
    mean = 1e6 * ABOUT.exposure_s
    assert abs(glow[:, 0, -1].mean() - mean) < 5 * np.sqrt(mean / FRAMES)
    assert glow[:, -1, 0].mean() < mean / 10


def test_cosmic_rays_come_at_their_rate() -> None:
    """A frame has none with the chance exp(-rate x exposure x area); within 5 sigma of 200."""
    many = dataclasses.replace(ABOUT, frames=tuple(range(200)))
    dark = np.zeros((200, HEIGHT, WIDTH), dtype=np.float32)
    hit = strange_charge.cosmic_rays(dark, 1e4, many)
    chance = 1 - np.exp(-1e4 * ABOUT.exposure_s * HEIGHT * WIDTH / 1e6)
    found = np.count_nonzero((hit > 0).any(axis=(1, 2)))
    assert abs(found - 200 * chance) < 5 * np.sqrt(200 * chance * (1 - chance))


def test_only_green_beside_red_is_brighter() -> None:
    flat = np.full((1, HEIGHT, WIDTH), 103.0, dtype=np.float32)
    out = strange_signal.green_imbalance(flat, 0.1, ABOUT)[0]
    assert out[0, 1] == pytest.approx(113.0)
    assert out[0, 0] == out[1, 0] == out[1, 1] == 103.0


def test_companding_leaves_one_code_in_eight() -> None:
    """Levels 0 to 32 = round(255 / 8), without level 1: code 1 is at the root's 31.9 / 16 = 2."""
    ramp = np.arange(256, dtype=np.float32).reshape(1, 16, 16)
    assert len(np.unique(strange_signal.companding(ramp, 1.0, ABOUT))) == 32


def test_a_torn_frame_ends_as_the_one_before_it() -> None:
    codes = np.arange(FRAMES, dtype=np.float32)[:, None, None] * np.ones((1, HEIGHT, WIDTH))
    torn = strange_signal.tearing(codes, 1.0, ABOUT)
    assert (torn[0] == 0).all()
    for k in range(1, FRAMES):
        assert set(np.unique(torn[k])) <= {k - 1.0, float(k)}
        assert (np.diff(torn[k][:, 0]) <= 0).all()


def test_infrared_leaks_under_hot_lamps_alone() -> None:
    rate = given("rate")
    cold = dataclasses.replace(ABOUT, lamps=("fluorescent",))
    np.testing.assert_array_equal(strange_light.infrared_leak(rate, 0.1, cold), rate)
    added = strange_light.infrared_leak(rate, 0.1, ABOUT) - rate
    np.testing.assert_allclose(added, 0.1 * rate[..., :1] * np.ones(3), rtol=1e-4)


def test_a_ghost_is_upside_down() -> None:
    rate = np.zeros((1, HEIGHT, WIDTH, 3), dtype=np.float32)
    rate[:, : HEIGHT // 2] = 1000.0
    added = strange_light.ghost(rate, 0.1, ABOUT) - rate
    below, above = HEIGHT // 2 + 5, HEIGHT // 2 - 5
    assert added[0, below, WIDTH // 2, 1] == pytest.approx(100.0)
    assert added[0, above, WIDTH // 2, 1] == pytest.approx(0.0, abs=1e-3)
