"""FITS, one file a shot: axes column, row, (colour,) frame, as astronomers have them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from astropy.io import fits
from numpy.typing import NDArray

from camtruth.exchange.format import EVERY_KIND, Format, one_file_a_shot, pieces
from camtruth.exchange.source import Source
from sensor.frames import Frames

BLOCK = 2880
"""FITS files are made of blocks of this many bytes."""

SIGNED = 2**15
"""FITS has no unsigned 16-bit type: it stores value - 32768, and BZERO says so."""


def header(source: Source, frames: Frames) -> fits.Header:
    """The header of a shot: the standard's keywords where it has one."""
    shape = _planes(frames.dn[:1]).shape[1:]
    shot = frames.shot
    head = fits.Header()
    head["SIMPLE"] = (True, "conforms to the FITS standard")
    head["BITPIX"] = 8 * frames.dn.dtype.itemsize
    head["NAXIS"] = 1 + len(shape)
    for axis, length in enumerate((*shape[::-1], frames.count), start=1):
        head[f"NAXIS{axis}"] = length
    if frames.dn.dtype.itemsize == 2:
        head["BSCALE"], head["BZERO"] = 1, SIGNED
    head["BUNIT"] = "adu"
    head["INSTRUME"] = (_ascii(source.document.camera), "camera")
    head["OBJECT"] = (_ascii(shot.label), "label of the shot")
    head["EXPTIME"] = (shot.exposure_s, "[s] exposure of a frame")
    head["LAMP"] = (_ascii(",".join(shot.light)), "lamps that are on")
    head["LEVEL"] = (",".join(f"{level:g}" for level in shot.level), "of each lamp")
    head["DATAMAX"] = (frames.top_dn, "largest code")
    if frames.cfa is not None and not frames.demosaiced:
        head["BAYERPAT"] = (frames.cfa, "colours of (0,0) (0,1) (1,0) (1,1)")
        head["ROWORDER"] = ("TOP-DOWN", "the first row is the top one")
    if shot.temperature_c is not None:
        head["CCD-TEMP"] = (shot.temperature_c, "[degC] of the sensor")
    if shot.interval_s is not None:
        head["INTERVAL"] = (shot.interval_s, "[s] from frame to frame")
    return head


def _ascii(text: str) -> str:
    return text.encode("ascii", "replace").decode()[:60]


def _planes(piece: NDArray[Any]) -> NDArray[Any]:
    """Colours before rows, as FITS viewers expect them."""
    return piece if piece.ndim == 3 else np.moveaxis(piece, 3, 1)


def _stored(piece: NDArray[Any]) -> bytes:
    planes = _planes(piece)
    if planes.dtype.itemsize == 1:
        return planes.tobytes()
    return (planes ^ np.uint16(SIGNED)).astype(">u2").tobytes()


def save(path: Path, source: Source, frames: Frames) -> None:
    """Write a shot, piece by piece, so that memory does not grow with the frames."""
    written = 0
    with path.open("wb") as stream:
        stream.write(header(source, frames).tostring().encode("ascii"))
        for _first, piece in pieces(frames):
            written += stream.write(_stored(piece))
        stream.write(bytes(-written % BLOCK))


FORMAT = Format(
    name="fits",
    says="FITS, one file a shot, exposure and temperature in the header",
    media_type="image/fits",
    reading="from astropy.io import fits; frames = fits.getdata(FILE)",
    pixels=EVERY_KIND,
    write=one_file_a_shot("fits", save),
    stack="{label}.fits",
    native=True,
)
