"""Video by FFmpeg through PyAV, frame by frame: what the decoder gives, converted as little as
can be. Grey stays grey with all its bits; RGB stays RGB; anything else (YUV) is converted to
8-bit RGB by FFmpeg, and the import says so."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.library import library
from camtruth.exchange.reader import Header, Reader, Roll
from foundation.errors import InputError
from foundation.quiet import quiet
from sensor.stack_files import refuse_size

RGB = ("rgb24", "bgr24", "bgr0", "rgb0", "0rgb", "0bgr", "gbrp", "rgba", "bgra")
"""Pixel formats whose 8-bit colours are rgb24 without loss."""

GREY_BITS = {
    "gray": 8,
    "gray9le": 9,
    "gray10le": 10,
    "gray12le": 12,
    "gray14le": 14,
    "gray16le": 16,
}


def read(path: Path) -> Roll:
    """The frames of the first video stream.

    Raises:
        ExchangeError: when it is damaged or holds no video.
        CaptureError: when its frames are larger than the limit.
    """
    av = library("av", "to read video")
    if not path.is_file():
        raise ExchangeError(f"no file {path}", "expected a video", "check the path")
    try:
        with quiet(), av.open(str(path)) as file:
            if not file.streams.video:
                raise _damaged(path, "it holds no video")
            context = file.streams.video[0].codec_context
            refuse_size(path, (context.height, context.width))
            pix_fmt = str(context.pix_fmt)
    except (av.FFmpegError, OSError, ValueError) as problem:
        if isinstance(problem, InputError):
            raise
        raise _damaged(path, str(problem)) from None
    grey = pix_fmt in GREY_BITS
    exact = grey or pix_fmt in RGB
    told = Header(
        where="video",
        bits=GREY_BITS.get(pix_fmt, 8),
        conversion=None if exact else f"{pix_fmt} to rgb24 by FFmpeg",
    )
    wanted = None if grey else "rgb24"
    return Roll(told=told, frames=_frames(av, path, wanted), several=True)


def _frames(av: Any, path: Path, wanted: str | None) -> Iterator[NDArray[Any]]:
    try:
        with av.open(str(path)) as file:
            stream = file.streams.video[0]
            decoder = file.decode(stream)
            while True:
                with quiet():
                    frame = next(decoder, None)
                if frame is None:
                    return
                refuse_size(path, (frame.height, frame.width))
                if frame.is_corrupt:
                    raise _damaged(path, "a frame is corrupt")
                yield np.ascontiguousarray(frame.to_ndarray(format=wanted))
    except (av.FFmpegError, OSError, ValueError) as problem:
        if isinstance(problem, InputError):
            raise
        raise _damaged(path, str(problem)) from None


def _damaged(path: Path, text: str) -> ExchangeError:
    return ExchangeError(f"cannot read {path} ({text})", "expected a whole video", "copy it again")


READER = Reader(name="video", read=read, endings=(".mkv", ".avi", ".mp4", ".mov", ".webm"))
