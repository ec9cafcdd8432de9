"""DNG for raw Bayer frames, one file a frame; written by tifffile, opened by any raw converter.

Reference: Adobe, Digital Negative Specification 1.7; tag numbers there, and in TIFF/EP
(ISO 12234-2) for the colour filter array and the exposure.
"""

from __future__ import annotations

import functools
from fractions import Fraction
from pathlib import Path
from typing import Any

import tifffile
from numpy.typing import NDArray

from camtruth.exchange.format import Format, one_file_a_frame
from camtruth.exchange.source import Source
from sensor.frames import Frames

ASCII, SHORT, RATIONAL, SRATIONAL, BYTE = 2, 3, 5, 10, 1

XYZ_TO_SRGB = (3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557, -0.2040, 1.0570)
"""IEC 61966-2-1. An assumption that makes previews look right; the raw values do not use it."""

D65 = 21
"""EXIF code of the illuminant of that matrix."""


def _rational(value: float) -> tuple[int, int]:
    fraction = Fraction(value).limit_denominator(1_000_000)
    return fraction.numerator, fraction.denominator


@functools.lru_cache(maxsize=1)
def tags(source: Source, frames: Frames) -> list[tuple[int, int, int, Any, bool]]:
    """The tags that make a TIFF a DNG."""
    assert frames.cfa is not None
    camera = f"camtruth {source.document.camera}".encode("ascii", "replace").decode()
    matrix = tuple(part for value in XYZ_TO_SRGB for part in _rational(value))
    black = _rational(max(0.0, source.black_dn))
    return [
        (50706, BYTE, 4, bytes((1, 4, 0, 0)), True),  # DNGVersion
        (50707, BYTE, 4, bytes((1, 1, 0, 0)), True),  # DNGBackwardVersion
        (50708, ASCII, len(camera) + 1, camera, True),  # UniqueCameraModel
        (271, ASCII, 9, "camtruth", True),  # Make
        (272, ASCII, len(camera) + 1, camera, True),  # Model
        (33421, SHORT, 2, (2, 2), True),  # CFARepeatPatternDim
        (33422, BYTE, 4, bytes("RGB".index(c) for c in frames.cfa), True),  # CFAPattern
        (50714, RATIONAL, 1, black, True),  # BlackLevel
        (50717, SHORT, 1, frames.top_dn, True),  # WhiteLevel
        (50721, SRATIONAL, 9, matrix, True),  # ColorMatrix1
        (50778, SHORT, 1, D65, True),  # CalibrationIlluminant1
        (50728, RATIONAL, 3, (1, 1, 1, 1, 1, 1), True),  # AsShotNeutral
        (33434, RATIONAL, 1, _rational(frames.shot.exposure_s), True),  # ExposureTime
    ]


def save(path: Path, source: Source, frames: Frames, frame: NDArray[Any]) -> None:
    """Write a frame, uncompressed, every code as it is."""
    tifffile.imwrite(
        path,
        frame,
        photometric="cfa",
        metadata=None,
        software="camtruth",
        subfiletype=0,
        extratags=tags(source, frames),
    )


FORMAT = Format(
    name="dng",
    says="DNG, raw Bayer, one file a frame",
    media_type="image/x-adobe-dng",
    reading="import rawpy; frame = rawpy.imread(FILE).raw_image_visible.copy()",
    pixels=("bayer8", "bayer16"),
    write=one_file_a_frame("dng", save, packed=False),
    stack="{label}/*.dng",
)
