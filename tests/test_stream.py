"""Streams: what may change the numbers and what may not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from foundation.backend import backend
from sensor.stream import Stream
from tests.backends import BACKENDS
from tests.harness import SIGNIFICANCE, assert_agree, z_limit

SIDE = 64


def stream(where: str, **changes: object) -> Stream:
    plain = Stream(
        backend=backend(where), seed=1, body_seed=2, effect="row", shot="a", frames=range(4)
    )
    return dataclasses.replace(plain, **changes)


def numbers(s: Stream, use: str = "") -> np.ndarray:
    values = s.normal(SIDE, SIDE, use=use)
    return np.asarray(values.numpy(), dtype=np.float64).reshape(values.shape)


@pytest.mark.parametrize("where", BACKENDS)
def test_a_frame_is_the_same_alone_and_in_any_batch(where: str) -> None:
    whole = numbers(stream(where, frames=range(-2, 6)))
    for k in range(-2, 6):
        assert np.array_equal(numbers(stream(where, frames=range(k, k + 1)))[0], whole[k + 2])


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize(
    "change", [{"seed": 9}, {"effect": "column"}, {"shot": "b"}, {"frames": range(4, 8)}]
)
def test_every_part_of_the_address_gives_unrelated_numbers(where: str, change: dict) -> None:
    a, b = numbers(stream(where)), numbers(stream(where, **change))
    correlation = np.corrcoef(a.ravel(), b.ravel())[0, 1]
    assert abs(correlation) < z_limit(4) / np.sqrt(a.size)


@pytest.mark.parametrize("where", BACKENDS)
def test_body_numbers_depend_on_the_body_and_the_effect_alone(where: str) -> None:
    base = numbers(stream(where).body)
    assert base.shape == (1, SIDE, SIDE)
    for change in ({"seed": 9}, {"shot": "b"}, {"frames": range(7, 9)}):
        assert np.array_equal(numbers(stream(where, **change).body), base)
    for change in ({"body_seed": 3}, {"effect": "column"}):
        assert not np.array_equal(numbers(stream(where, **change).body), base)


@pytest.mark.parametrize("where", BACKENDS)
def test_shot_numbers_are_the_same_in_every_frame_and_differ_by_shot(where: str) -> None:
    base = numbers(stream(where).whole_shot)
    assert np.array_equal(numbers(stream(where, frames=range(7, 9)).whole_shot), base)
    assert not np.array_equal(numbers(stream(where, shot="b").whole_shot), base)


@pytest.mark.parametrize("where", BACKENDS)
def test_another_use_gives_other_numbers_and_the_same_use_the_same(where: str) -> None:
    s = stream(where)
    assert np.array_equal(numbers(s, "phase"), numbers(s, "phase"))
    assert not np.array_equal(numbers(s, "phase"), numbers(s, "depth"))


@pytest.mark.parametrize("where", BACKENDS)
def test_normal_and_uniform_numbers_follow_their_laws(where: str) -> None:
    s = stream(where, frames=range(16))
    normal = np.asarray(s.normal(SIDE, SIDE).numpy()).ravel()
    uniform = np.asarray(s.uniform(SIDE, SIDE).numpy()).ravel()
    assert stats.kstest(normal, "norm").pvalue > SIGNIFICANCE / 2
    assert stats.kstest(uniform, "uniform").pvalue > SIGNIFICANCE / 2
    assert uniform.min() >= 0
    assert uniform.max() < 1


@pytest.mark.parametrize("where", BACKENDS)
def test_neighbouring_pixels_and_frames_are_independent(where: str) -> None:
    values = numbers(stream(where, frames=range(16)))
    pairs = {
        "right": (values[:, :, 1:], values[:, :, :-1]),
        "below": (values[:, 1:], values[:, :-1]),
        "next frame": (values[1:], values[:-1]),
        "fourth": (values[:, :, 4:], values[:, :, :-4]),
    }
    products = [(a * b).mean() for a, b in pairs.values()]
    assert_agree(products, 0.0, [1 / np.sqrt(a.size) for a, _ in pairs.values()])
