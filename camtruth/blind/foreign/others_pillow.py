"""libjpeg through Pillow, at full and at half resolution of chroma."""

from __future__ import annotations

import functools
import io

import numpy as np
from PIL import Image

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

SOURCE = "libjpeg"


def jpeg(codes: Numbers, strength: float, about: About, *, subsampling: int) -> Numbers:
    """Written and read as JPEG of quality 100 - `strength`."""
    out = []
    for frame in np.clip(codes, 0, 255).astype(np.uint8):
        stream = io.BytesIO()
        Image.fromarray(frame).save(
            stream, "jpeg", quality=round(100 - strength), subsampling=subsampling
        )
        out.append(np.asarray(Image.open(stream)))
    return np.stack(out).astype(codes.dtype)


OUTSIDERS = tuple(
    Outsider(
        name=f"libjpeg {name}",
        source=SOURCE,
        answers=answers,
        stage="transport",
        place="codes",
        weakest=0,
        strongest=80,
        act=functools.partial(jpeg, subsampling=subsampling),
        order=20,
    )
    for name, subsampling, answers in (
        ("4:4:4", 0, ("jpeg",)),
        ("4:2:0", 2, ("jpeg", "chroma_subsampling")),
    )
)
