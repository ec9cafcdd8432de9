"""NumPy's own files, one a shot."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camtruth.exchange.format import EVERY_KIND, Format, one_file_a_shot, pieces
from camtruth.exchange.source import Source
from sensor.frames import Frames


def save(path: Path, _: Source, frames: Frames) -> None:
    """Write a shot, piece by piece."""
    header = {
        "descr": np.lib.format.dtype_to_descr(frames.dn.dtype),
        "fortran_order": False,
        "shape": frames.dn.shape,
    }
    with path.open("wb") as stream:
        np.lib.format.write_array_header_1_0(stream, header)
        for _first, piece in pieces(frames):
            stream.write(piece.data)


FORMAT = Format(
    name="npy",
    says="NumPy arrays, one file a shot",
    media_type="application/octet-stream",
    reading="import numpy; frames = numpy.load(FILE, allow_pickle=False)",
    pixels=EVERY_KIND,
    write=one_file_a_shot("npy", save),
    stack="{label}.npy",
    native=True,
)
