"""What a reader of frames is, and which there are: one file each in camtruth/exchange/readers/."""

from __future__ import annotations

import functools
import importlib
import math
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Header:
    """What stands in a file's header; None where it says nothing.

    Attributes:
        where: the kind of header, as in "EXIF".
        exposure_s, temperature_c: of the frames.
        camera: its model.
        bits: significant bits of a sample.
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1).
        conversion: what was done to the stored samples to make them pixels, if anything.
    """

    where: str = "header"
    exposure_s: float | None = None
    temperature_c: float | None = None
    camera: str | None = None
    bits: int | None = None
    cfa: str | None = None
    conversion: str | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Roll:
    """The frames of one file, in their order, one at a time.

    Attributes:
        told: what the header says.
        frames: each (H, W) or (H, W, 3).
        several: whether the file can hold more than one frame.
    """

    told: Header
    frames: Iterator[NDArray[Any]]
    several: bool


@dataclass(frozen=True, kw_only=True)
class Reader:
    """A family of formats that frames are imported from.

    Attributes:
        name: for people.
        read: the frames of a file, or of a folder with a mark, and what its header says. Raises an
            `InputError` for one that is damaged or larger than the limit.
        endings: of its files, in small letters and with their dot.
        marks: files of which a folder holds one where it is read as a whole.
    """

    name: str
    read: Callable[[Path], Roll]
    endings: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()

    def reads(self, path: Path) -> bool:
        """Whether a file or folder is of its kind, by its name or its marks."""
        if path.is_dir():
            return any((path / mark).is_file() for mark in self.marks)
        return path.suffix.lower() in self.endings


@functools.cache
def readers() -> tuple[Reader, ...]:
    """Every reader, found by being a file in camtruth/exchange/readers/ with a READER."""
    import camtruth.exchange.readers as folder

    return tuple(
        importlib.import_module(f"{folder.__name__}.{found.name}").READER
        for found in pkgutil.iter_modules(folder.__path__)
    )


def reader_of(path: Path) -> Reader | None:
    """The reader of a file or folder; None where there is none."""
    return next((reader for reader in readers() if reader.reads(path)), None)


def kinds() -> tuple[str, str]:
    """What is read, in words: the endings of files, and the names of what is a folder."""
    endings = sorted(ending for reader in readers() for ending in reader.endings)
    folders = [reader.name for reader in readers() if reader.marks]
    return ", ".join(endings), " or ".join(folders)


def positive(value: Any) -> float | None:
    """A header's number, where it is one that can be an exposure."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return number if math.isfinite(number) and number > 0 else None
