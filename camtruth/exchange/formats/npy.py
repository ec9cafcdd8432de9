"""NumPy's own files, one a shot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from camtruth.exchange.format import (
    EVERY_KIND,
    Format,
    FrameFile,
    once,
    pieces,
    shot_by_shot,
)
from camtruth.exchange.source import Source
from sensor.frames import Frames


def write(folder: Path, _: Source, frames: Frames) -> Iterator[FrameFile]:
    """Write a shot, piece by piece."""
    name = f"{frames.shot.label}.npy"
    header = {
        "descr": np.lib.format.dtype_to_descr(frames.dn.dtype),
        "fortran_order": False,
        "shape": frames.dn.shape,
    }

    def make(path: Path) -> None:
        with path.open("wb") as stream:
            np.lib.format.write_array_header_1_0(stream, header)
            for _first, piece in pieces(frames):
                stream.write(piece.data)

    kept = once(folder / name, make)
    yield FrameFile(name=name, shot=frames.shot.label, first=0, count=frames.count, kept=kept)


FORMAT = Format(
    name="npy",
    says="NumPy arrays, one file a shot",
    media_type="application/octet-stream",
    reading="import numpy; frames = numpy.load(FILE, allow_pickle=False)",
    pixels=EVERY_KIND,
    write=shot_by_shot(write),
    stack="{label}.npy",
    native=True,
)
