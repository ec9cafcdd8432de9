"""DNG and the raw files of cameras, by LibRaw through rawpy: the mosaic, untouched."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.library import library
from camtruth.exchange.reader import Header, Reader, Roll, positive
from foundation.errors import InputError
from foundation.quiet import quiet
from sensor.stack_files import refuse_size


def read(path: Path) -> Roll:
    """The visible photosites of a raw file: codes as they were stored, black level included.

    Raises:
        ExchangeError: when it is damaged, or no mosaic of 2 x 2.
        CaptureError: when it is larger than the limit.
    """
    rawpy = library("rawpy", "to read raw files")
    if not path.is_file():
        raise ExchangeError(f"no file {path}", "expected a raw file", "check the path")
    try:
        with quiet(), rawpy.imread(str(path)) as raw:
            refuse_size(path, (raw.sizes.height, raw.sizes.width))
            return _roll(path, raw)
    except InputError:
        raise
    except (rawpy.LibRawError, ValueError, OSError, RuntimeError) as problem:
        text = problem.args[0] if problem.args else type(problem).__name__
        text = text.decode(errors="replace") if isinstance(text, bytes) else str(text)
        raise ExchangeError(
            f"cannot read {path} ({text})", "expected a whole raw file", "copy it again"
        ) from None


def _roll(path: Path, raw: Any) -> Roll:
    if raw.raw_pattern is None or raw.raw_pattern.shape != (2, 2):
        raise ExchangeError(
            f"{path} has no mosaic of 2 x 2 colours",
            "expected raw frames of a Bayer filter",
            "convert it with the maker's program",
        )
    colours = raw.raw_colors_visible[:2, :2].ravel()
    white = int(raw.white_level)
    bits = max(1, white.bit_length())
    frame = np.array(raw.raw_image_visible, dtype=np.uint8 if bits <= 8 else np.uint16)
    if int(np.max(raw.raw_image_visible, initial=0)) >= 2**bits:
        bits = int(np.max(raw.raw_image_visible)).bit_length()
        frame = np.array(raw.raw_image_visible, dtype=np.uint16)
    told = Header(
        where="EXIF",
        exposure_s=positive(getattr(getattr(raw, "other", None), "shutter_speed", None)),
        bits=bits,
        cfa="".join(raw.color_desc.decode()[k] for k in colours),
    )

    def one() -> Iterator[NDArray[Any]]:
        yield frame

    return Roll(told=told, frames=one(), several=False)


READER = Reader(
    name="raw files",
    read=read,
    endings=(".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf", ".rw2", ".orf", ".pef", ".srw"),
)
