"""A .npy stack written frame by frame, when nobody knows yet how many there will be."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.format import once


@dataclass(frozen=True, kw_only=True)
class Written:
    """What a finished stack holds.

    Attributes:
        count: frames.
        shape: of a frame.
        sample_bits: 8 or 16.
        bits_used: every bit that any sample sets, OR-ed together.
        kept: whether it stood there already.
    """

    count: int
    shape: tuple[int, ...]
    sample_bits: int
    bits_used: int
    kept: bool = False


def stack_once(path: Path, label: str, frames: Iterator[NDArray[Any]], shift: int) -> Written:
    """Write a stack whole or not at all; one that stands there is looked at, not made again.

    Raises:
        ExchangeError: as `write_stack` does.
    """
    made: list[Written] = []
    once(path, lambda beside: made.append(write_stack(beside, label, frames, shift)))
    return made[0] if made else _standing(path)


def _standing(path: Path) -> Written:
    stack = np.load(path, mmap_mode="r", allow_pickle=False)
    used = 0
    for frame in stack:
        used |= int(np.bitwise_or.reduce(frame, axis=None))
    return Written(
        count=len(stack),
        shape=stack.shape[1:],
        sample_bits=8 * stack.dtype.itemsize,
        bits_used=used,
        kept=True,
    )


def write_stack(path: Path, label: str, frames: Iterator[NDArray[Any]], shift: int) -> Written:
    """Write frames of one shape and type; samples are shifted to the right by `shift` bits.

    Raises:
        ExchangeError: when frames differ in size or type, there are none, or bits would be lost.
    """
    first = next(frames, None)
    if first is None:
        raise ExchangeError(
            f"no frame in shot '{label}'", "expected one or more", "check its files"
        )
    used = count = 0
    with path.open("wb") as stream:
        _header(stream, first, 0)
        frame: NDArray[Any] | None = first
        while frame is not None:
            if frame.shape != first.shape or frame.dtype != first.dtype:
                raise ExchangeError(
                    f"frame {count} of shot '{label}' has shape {frame.shape} of {frame.dtype}",
                    f"expected {first.shape} of {first.dtype} as the first",
                    "put frames of one size and type in one shot",
                )
            set_here = int(np.bitwise_or.reduce(frame, axis=None)) if frame.size else 0
            if shift and set_here & (2**shift - 1):
                raise ExchangeError(
                    f"frame {count} of shot '{label}' uses the lowest {shift} bits",
                    "expected them to be 0 in samples that are to be shifted",
                    "pass a smaller --shift",
                )
            used |= set_here >> shift
            stream.write(np.ascontiguousarray(frame >> shift if shift else frame).data)
            count += 1
            frame = next(frames, None)
        stream.seek(0)
        _header(stream, first, count)
    return Written(
        count=count, shape=first.shape, sample_bits=8 * first.dtype.itemsize, bits_used=used
    )


def _header(stream: IO[bytes], frame: NDArray[Any], count: int) -> None:
    """NumPy leaves room for the first axis to grow, so the header keeps its length."""
    np.lib.format.write_array_header_1_0(
        stream,
        {
            "descr": np.lib.format.dtype_to_descr(frame.dtype),
            "fortran_order": False,
            "shape": (count, *frame.shape),
        },
    )
