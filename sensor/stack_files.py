"""Stacks of frames from files: .npy, multi-page TIFF, or a series of PNG, TIFF or FITS images."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foundation.errors import InputError
from foundation.quiet import quiet
from sensor.errors import CaptureError

MAX_PIXELS_VARIABLE = "CAMTRUTH_MAX_PIXELS"
DEFAULT_MAX_PIXELS = 100_000_000
"""Pixels of one frame beyond which a file is taken for a mistake or an attack."""

NPY = b"\x93NUMPY"
"""What every .npy file begins with."""


def max_pixels() -> int:
    """The limit on the pixels of a frame, which CAMTRUTH_MAX_PIXELS sets."""
    text = os.environ.get(MAX_PIXELS_VARIABLE, str(DEFAULT_MAX_PIXELS))
    try:
        return int(text)
    except ValueError:
        raise CaptureError(
            f"{MAX_PIXELS_VARIABLE} = '{text}'", "expected a whole number", "correct or unset it"
        ) from None


def read_stack(
    folder: Path, pattern: str, inside: Callable[[Path, str], Path]
) -> NDArray[np.generic]:
    """The frames that a manifest's `frames` names: (N, H, W) or (N, H, W, 3).

    Args:
        folder: the capture folder.
        pattern: a .npy file, a .tif file, or a glob of images taken in the order of their names.
        inside: gives the path of a name, or raises if it leaves the folder.

    Raises:
        CaptureError: when a file is missing, damaged, or no image.
    """
    named = inside(folder, pattern)
    if pattern.endswith(".npy"):
        if _is_glob(pattern):
            raise CaptureError(
                f"frames = '{pattern}' in {folder}",
                "expected one .npy file with all frames of the shot; globs are for .png, .tif and"
                " .fits",
                "put the frames into one .npy file",
            )
        return _npy(named)
    if not _is_glob(pattern):
        stack = _image(named)
        return stack if _is_stack(named, stack) else stack[None]
    names = matching(folder, pattern)
    images = [_single(inside(folder, name)) for name in names]
    for name, image in zip(names, images, strict=True):
        if image.shape != images[0].shape or image.dtype != images[0].dtype:
            raise CaptureError(
                f"{name} has shape {image.shape} of {image.dtype}",
                f"expected {images[0].shape} of {images[0].dtype} as {names[0]} has",
                "put frames of one size and type in one shot",
            )
    return np.stack(images)


def _single(path: Path) -> NDArray[Any]:
    """The one image of a file; FITS has its colours before rows."""
    image = _image(path)
    planes = path.suffix.lower() in (".fits", ".fit") and image.ndim == 3 and len(image) == 3
    return np.moveaxis(image, 0, 2) if planes else image


def matching(folder: Path, pattern: str) -> list[str]:
    """The files that a glob names, in the order of their names; it must lie in the folder.

    Raises:
        CaptureError: when there is none, or the pattern is no glob.
    """
    try:
        names = sorted(path.relative_to(folder).as_posix() for path in folder.glob(pattern))
    except (ValueError, NotImplementedError, OSError, RecursionError) as problem:
        raise CaptureError(
            f"'{pattern[:100]}' is no pattern of file names ({problem})",
            "expected one as in 'lit/*.png'",
            "correct 'frames'",
        ) from None
    if not names:
        raise CaptureError(
            f"no file matches '{pattern}' in {folder}", "expected at least one", "correct 'frames'"
        )
    return names


def files_of(folder: Path, pattern: str) -> list[str]:
    """The file, or the files, that a manifest's `frames` names."""
    return matching(folder, pattern) if _is_glob(pattern) else [pattern]


def _is_glob(pattern: str) -> bool:
    return any(mark in pattern for mark in "*?[")


def _is_stack(path: Path, image: NDArray[Any]) -> bool:
    """Whether a file's array has a frame axis; only TIFF and FITS can have one."""
    pages = path.suffix.lower() in (".tif", ".tiff", ".fits", ".fit")
    return pages and (image.ndim == 4 or (image.ndim == 3 and image.shape[-1] != 3))


def _npy(path: Path) -> NDArray[np.generic]:
    try:
        with path.open("rb") as file:
            if not file.read(len(NPY)).startswith(NPY):
                raise ValueError("it does not begin as a .npy file does")
        with quiet():
            stack = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as problem:
        # NumPy runs Python's tokenizer over a damaged header, and lets through what that raises.
        raise _damaged(path, problem, "a whole .npy file of numbers") from None
    if not isinstance(stack, np.ndarray) or stack.dtype.hasobject:
        raise _damaged(path, TypeError("it holds Python objects"), "a .npy file of numbers")
    refuse_size(path, stack.shape[1:3])
    return stack


def _image(path: Path) -> NDArray[Any]:
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise CaptureError(
            f"{path} is of a kind that is not read",
            f"expected .npy, {', '.join(sorted(_READERS))}",
            "convert it",
        )
    if not path.is_file():
        raise CaptureError(f"no file {path}", "expected the frames there", "correct 'frames'")
    try:
        with quiet():
            return reader(path)
    except InputError:
        raise
    except Exception as problem:
        # Three libraries raise some twenty kinds of error on damaged files; all mean the same.
        raise _damaged(path, problem, "a whole image") from None


def _tiff(path: Path) -> NDArray[Any]:
    """Every page in order, whatever series they were written in; one page alone is one image."""
    import tifffile

    with tifffile.TiffFile(path) as file:
        series = [each for each in file.series if not each.keyframe.is_reduced]
        shapes = [_stack_shape(each.shape) for each in series]
        first = shapes[0][1:], series[0].dtype
        for each, shape in zip(series, shapes, strict=True):
            refuse_size(path, shape[1:3])
            if (shape[1:], each.dtype) != first:
                raise CaptureError(
                    f"{path} has pages of shape {shape[1:]} of {each.dtype}",
                    f"expected {first[0]} of {first[1]} as its first page has",
                    "put frames of one size and type in one file",
                )
        if len(series) == 1:
            return np.asarray(series[0].asarray())
        stack = np.empty((sum(shape[0] for shape in shapes), *first[0]), first[1])
        done = 0
        for each, shape in zip(series, shapes, strict=True):
            each.asarray(out=stack[done : done + shape[0]].reshape(each.shape))
            done += shape[0]
    return stack


def _stack_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of an array of frames, also where it is that of one image."""
    single = len(shape) == 2 or (len(shape) == 3 and shape[-1] == 3)
    return (1, *shape) if single else shape


def _png(path: Path) -> NDArray[Any]:
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None  # Pillow's own limit; ours is looked at before pixels are made
    with Image.open(path) as image:
        refuse_size(path, image.size)
        if image.mode not in ("L", "RGB", "I;16", "I;16B", "I"):
            raise CaptureError(
                f"{path} has pixels of mode {image.mode}",
                "expected grey or RGB without transparency",
                "convert it",
            )
        values = np.asarray(image)
    return values.astype(np.uint16) if values.dtype.kind == "i" else values


def _fits(path: Path) -> NDArray[Any]:
    from astropy.io import fits

    with fits.open(path, memmap=False) as file:
        header = file[0].header
        refuse_size(path, (header.get("NAXIS1", 0), header.get("NAXIS2", 0)))
        values = np.asarray(file[0].data)
    if values.ndim == 4 and values.shape[1] == 3 != values.shape[3]:
        values = np.moveaxis(values, 1, 3)  # FITS has colours before rows
    return values.astype(values.dtype.newbyteorder("="))


_READERS: dict[str, Callable[[Path], NDArray[Any]]] = {
    ".tif": _tiff,
    ".tiff": _tiff,
    ".png": _png,
    ".fits": _fits,
    ".fit": _fits,
}

ENDINGS = (".npy", *_READERS)
"""Of every file that is read."""


def refuse_size(path: Path, sides: tuple[int, ...]) -> None:
    """Refuse a file whose frames claim more pixels than the limit, before they are made.

    Raises:
        CaptureError: with the limit and how to raise it.
    """
    pixels = int(np.prod([int(side) for side in sides], dtype=np.float64)) if sides else 0
    if pixels > max_pixels():
        raise CaptureError(
            f"{path} has frames of {pixels} pixels",
            f"expected at most {max_pixels()}",
            f"raise {MAX_PIXELS_VARIABLE} if it is right",
        )


def _damaged(path: Path, problem: Exception, expected: str) -> CaptureError:
    text = getattr(problem, "strerror", None) or str(problem) or type(problem).__name__
    return CaptureError(f"cannot read {path} ({text})", f"expected {expected}", "copy it again")
