"""Zarr arrays of frames."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.library import library
from camtruth.exchange.reader import Header, Reader, Roll, positive
from sensor.stack_files import refuse_size


def read(path: Path) -> Roll:
    """The frames of an array (N, H, W) or (N, H, W, 3).

    Raises:
        ExchangeError: when it is damaged or no such array.
        CaptureError: when its frames are larger than the limit.
    """
    zarr = library("zarr", "to read Zarr")
    try:
        array = zarr.open_array(str(path), mode="r")
        shape, kind = array.shape, array.dtype
        exposure = positive(array.attrs.get("exposure_s"))
    except Exception as problem:
        # Zarr raises some ten kinds of error on damaged folders; all mean the same.
        raise _damaged(path, problem) from None
    if len(shape) not in (3, 4) or kind not in (np.uint8, np.uint16):
        raise ExchangeError(
            f"{path} has shape {shape} of {kind}",
            "expected (N, H, W) or (N, H, W, 3) of 8 or 16 bits",
            "convert it",
        )
    refuse_size(path, shape[1:3])
    return Roll(
        told=Header(where="Zarr attributes", exposure_s=exposure),
        frames=_frames(path, array),
        several=True,
    )


def _frames(path: Path, array: Any) -> Iterator[NDArray[Any]]:
    step = max(1, int(array.chunks[0]))
    try:
        for first in range(0, array.shape[0], step):
            yield from np.asarray(array[first : first + step])
    except Exception as problem:
        raise _damaged(path, problem) from None


def _damaged(path: Path, problem: Exception) -> ExchangeError:
    text = str(problem) or type(problem).__name__
    return ExchangeError(
        f"cannot read {path} ({text[:200]})", "expected a Zarr array", "copy it again"
    )


READER = Reader(name="Zarr", read=read, marks=("zarr.json", ".zarray"))  # arrays and groups
