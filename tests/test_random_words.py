"""Random words and normal numbers against Dr.Jit's generator and float64 arithmetic."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

from foundation.backend import backend, probe
from sensor.box_muller import normals
from sensor.philox import Words, fractions, words

COUNT = 1 << 18
KEY = 0x923456789ABCDEF1
BACKENDS = [name for name in ("llvm",) if probe(name).works]
WORD = 2.0**32


def drawn(where: str) -> tuple[Any, Words]:
    arrays = backend(where).arrays
    dr = importlib.import_module("drjit")
    lane = dr.arange(arrays.UInt32, COUNT)
    key, frame = dr.opaque(arrays.UInt64, KEY), dr.full(arrays.UInt32, 2**32 - 7, COUNT)
    return arrays.Philox4x32(key, lane, frame), words(key, lane, frame)


@pytest.mark.parametrize("where", BACKENDS)
def test_words_are_those_of_the_generator_of_dr_jit(where: str) -> None:
    theirs, ours = drawn(where)
    for a, b in zip(theirs.next_uint32x4(), ours, strict=True):
        assert np.array_equal(a.numpy(), b.numpy())
    theirs, ours = drawn(where)
    for a, b in zip(theirs.next_float32x4(), fractions(ours), strict=True):
        assert np.array_equal(a.numpy(), b.numpy())


@pytest.mark.parametrize("where", BACKENDS)
def test_normal_numbers_are_those_of_the_formula(where: str) -> None:
    """Where u is near 1 it is a float32, off by 2^-25, and r off by that over r."""
    _, four = drawn(where)
    ours = [np.asarray(n.numpy(), float) for n in normals(four)]
    w = [np.asarray(word.numpy(), float) for word in four]
    for first, (turn, height) in zip((0, 2), ((w[0], w[2]), (w[1], w[3])), strict=True):
        r = np.sqrt(-2 * np.log((WORD - 0.5 - height) / WORD))
        allowed = 4e-7 * (1 + r) + 2.0**-24 / np.maximum(r, 2.0**-12)
        for k, wave in ((first, np.cos), (first + 1, np.sin)):
            assert (np.abs(ours[k] - r * wave(2 * np.pi * turn / WORD)) < allowed).all()


@pytest.mark.parametrize("where", BACKENDS)
def test_the_rarest_words_give_finite_numbers(where: str) -> None:
    arrays = backend(where).arrays
    edge = arrays.UInt32([0, 1, 2**31 - 1, 2**31, 2**32 - 1])
    for other in (0, 1, 2**31, 2**32 - 1):
        word = arrays.UInt32(other)
        for n in [*normals((edge, edge, word, word)), *normals((word, word, edge, edge))]:
            values = np.asarray(n.numpy())
            assert np.isfinite(values).all()
            assert np.abs(values).max() < 6.8
