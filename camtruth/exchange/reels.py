"""Which files of a folder are which shot, and their frames one after another.

A file of several frames (NPY, video, Zarr, FITS cube, multi-page TIFF) is a shot; so is each folder
of single images, in the order of their names. `shots.toml` or `capture.toml` says it outright.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.reader import Header, Roll, kinds, reader_of
from sensor.capture_folder import inside
from sensor.stack_files import matching

SAME_EXPOSURE = 1e-3
"""Frames of a shot may differ by this part in their stated exposure: cameras round it."""


@dataclass(frozen=True, kw_only=True)
class Reel:
    """The files of a shot, in order, and what the first one says."""

    label: str
    files: tuple[Path, ...]
    told: Header

    def frames(self) -> Iterator[NDArray[Any]]:
        """Every frame of every file.

        Raises:
            ExchangeError: when files of a shot state different exposures.
        """
        for path in self.files:
            roll = read(path)
            if not _alike(roll.told.exposure_s, self.told.exposure_s):
                raise ExchangeError(
                    f"{path} states an exposure of {roll.told.exposure_s} s",
                    f"expected {self.told.exposure_s} s as {self.files[0].name} states",
                    "put frames of one exposure in one folder",
                )
            yield from roll.frames


def _alike(a: float | None, b: float | None) -> bool:
    if a is None or b is None:
        return a == b
    return abs(a - b) <= SAME_EXPOSURE * b


def read(path: Path) -> Roll:
    """A file of frames, or a folder that is one.

    Raises:
        InputError: when it is none of a kind that is read, or damaged.
    """
    reader = reader_of(path)
    if reader is None:
        endings, folders = kinds()
        raise ExchangeError(
            f"{path} is of a kind that is not read",
            f"expected {endings} or {folders}",
            "convert it",
        )
    return reader.read(path)


def reel_of(label: str, files: Sequence[Path]) -> Reel:
    """A shot from its files; the first one is opened."""
    return Reel(label=label, files=tuple(files), told=read(files[0]).told)


def named(folder: Path, label: str, pattern: str) -> Reel:
    """A shot whose files a manifest names by a path or a glob.

    Raises:
        InputError: when there are none, or they leave the folder.
    """
    whole = inside(folder, pattern)
    if not set(pattern) & set("*?["):
        return reel_of(label, [whole])
    return reel_of(label, [inside(folder, name) for name in matching(folder, pattern)])


def discovered(folder: Path) -> tuple[list[Reel], list[Path]]:
    """The shots of a folder that nobody describes, and the files that were left aside.

    Raises:
        InputError: when there is no folder, or no frame in it.
    """
    if not folder.is_dir():
        raise ExchangeError(f"no folder {folder}", "expected one with frames", "check the path")
    reels: list[Reel] = []
    aside: list[Path] = []
    single: list[Path] = []
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        if path.is_dir():
            reels += _of_folder(inside(folder, path.name), aside)
        elif reader_of(path) is None:
            aside.append(path)
        elif read(inside(folder, path.name)).several:
            reels.append(reel_of(label_of(path.stem), [path]))
        else:
            single.append(path)
    if single:
        reels.append(reel_of(label_of(folder.resolve().name), single))
    if not reels:
        endings, folders = kinds()
        raise ExchangeError(
            f"no frames in {folder}",
            f"expected files that end in {endings}, or {folders}",
            "convert them, or check the path",
        )
    labels = [reel.label for reel in reels]
    for label in labels:
        if labels.count(label) > 1:
            raise ExchangeError(
                f"two shots in {folder} would be called '{label}'",
                "expected names that differ in letters, digits, dots and dashes",
                "rename a folder or file",
            )
    return reels, aside


def _of_folder(folder: Path, aside: list[Path]) -> list[Reel]:
    reader = reader_of(folder)
    if reader is not None:
        arrays = [p for p in sorted(folder.iterdir()) if p.is_dir() and reader.reads(p)]
        return [reel_of(label_of(path.name), [path]) for path in arrays or [folder]]
    files = []
    for path in sorted(folder.iterdir()):
        if path.is_file() and reader_of(path) is not None:
            files.append(inside(folder, path.name))
        else:
            aside.append(path)
    return [reel_of(label_of(folder.name), files)] if files else []


def label_of(name: str) -> str:
    """A name as labels of shots are spelt: letters, digits, dots, dashes."""
    label = re.sub(r"[^A-Za-z0-9._-]+", "-", name).lstrip("._-")[:100]
    return label or "shot"
