"""Frames of an exported folder as the libraries of others read them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensor.protocol import Protocol, Shot

PROTOCOL = Protocol(
    name="short",
    shot=(
        Shot(label="dark", exposure_s=0.03268, frames=3, temperature_c=21.5),
        Shot(label="dark-2", light=("incandescent",), level=(1.0,), exposure_s=0.03268, frames=18),
    ),
)

Stack = np.ndarray[Any, Any]


def by_opencv(folder: Path, label: str) -> Stack:
    import cv2

    files = sorted((folder / "frames" / label).iterdir())
    images = [cv2.imread(str(file), cv2.IMREAD_UNCHANGED) for file in files]
    return np.stack([i[..., ::-1] if i.ndim == 3 else i for i in images])


def by_pillow(folder: Path, label: str) -> Stack:
    from PIL import Image

    images = []
    for file in sorted((folder / "frames" / label).iterdir()):
        with Image.open(file) as image:
            images.append(np.array(image))
    return np.stack(images)


def by_tifffile(folder: Path, label: str) -> Stack:
    import tifffile

    pages = folder / "frames" / f"{label}.tif"
    if pages.exists():
        return tifffile.imread(pages)
    files = sorted((folder / "frames" / label).iterdir())
    return np.stack([tifffile.imread(file) for file in files])


def by_opencv_pages(folder: Path, label: str) -> Stack:
    import cv2

    name = str(folder / "frames" / f"{label}.tif")
    _, images = cv2.imreadmulti(name, flags=cv2.IMREAD_UNCHANGED)
    return np.stack([i[..., ::-1] if i.ndim == 3 else i for i in images])


def by_rawpy(folder: Path, label: str) -> Stack:
    rawpy = pytest.importorskip("rawpy")
    images = []
    for file in sorted((folder / "frames" / label).iterdir()):
        with rawpy.imread(str(file)) as raw:
            images.append(raw.raw_image_visible.copy())
            letters = raw.color_desc.decode()
            assert "".join(letters[k] for k in raw.raw_pattern.ravel()) == "GRBG"
            bits = 12 if raw.white_level > 255 else 8
            assert raw.white_level == 2**bits - 1
            assert set(raw.black_level_per_channel) == {3 * 2 ** (bits - 8)}
    return np.stack(images)


def by_astropy(folder: Path, label: str) -> Stack:
    from astropy.io import fits

    file = folder / "frames" / f"{label}.fits"
    shot = next(shot for shot in PROTOCOL.shot if shot.label == label)
    header = fits.getheader(file)
    assert header["EXPTIME"] == shot.exposure_s
    assert header.get("CCD-TEMP") == shot.temperature_c
    stack = fits.getdata(file)
    return np.moveaxis(stack, 1, 3) if stack.ndim == 4 else stack


def by_numpy(folder: Path, label: str) -> Stack:
    return np.load(folder / "frames" / f"{label}.npy", allow_pickle=False)


def by_zarr(folder: Path, label: str) -> Stack:
    zarr = pytest.importorskip("zarr")
    return zarr.open_array(str(folder / "frames/frames.zarr" / label), mode="r")[:]


def by_pyav(folder: Path, label: str) -> Stack:
    av = pytest.importorskip("av")
    with av.open(str(folder / "frames" / f"{label}.mkv")) as file:
        assert file.streams.video[0].codec_context.name == "ffv1"
        colour = file.streams.video[0].codec_context.pix_fmt == "bgr0"
        frames = file.decode(video=0)
        return np.stack([f.to_ndarray(format="rgb24" if colour else None) for f in frames])


PEERS: list[tuple[str, Callable[[Path, str], Stack]]] = [
    ("png", by_opencv),
    ("png", by_pillow),
    ("tiff", by_tifffile),
    ("tiff", by_opencv),
    ("tiff-pages", by_tifffile),
    ("tiff-pages", by_opencv_pages),
    ("dng", by_rawpy),
    ("fits", by_astropy),
    ("npy", by_numpy),
    ("zarr", by_zarr),
    ("ffv1", by_pyav),
]
