"""Lossless video: FFV1 in Matroska, one file a shot; written by FFmpeg through PyAV.

FFV1 version 3 with a checksum in every slice. Colours travel as bgr0, which FFV1 codes by a
reversible transform; grey and Bayer frames as gray or gray16le.

Reference: RFC 9043, FFV1 Video Coding Format Versions 0, 1 and 3.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from camtruth.exchange.format import EVERY_KIND, Format, one_file_a_shot, pieces
from camtruth.exchange.library import library
from camtruth.exchange.source import NOMINAL_INTERVAL_S, Source
from sensor.frames import Frames

OPTIONS = {"level": "3", "slices": "4", "slicecrc": "1", "g": "1"}
"""Every frame stands for itself; the number of slices is fixed, so that bytes are the same
whatever the number of cores."""

BIT_EXACT = {"fflags": "+bitexact"}
"""No date, no random identity, no program's name in the file."""


def save(path: Path, _: Source, frames: Frames) -> None:
    """Write a shot as a video; its clock is the shot's interval, or 1/15 s where none is known."""
    av = library("av", "to write FFV1 video")
    interval = frames.shot.interval_s
    rate = 1 / (Fraction(interval).limit_denominator(100_000) if interval else NOMINAL_INTERVAL_S)
    given = "rgb24" if frames.demosaiced else "gray" if frames.dn.itemsize == 1 else "gray16le"
    stored = "bgr0" if frames.demosaiced else given
    with av.open(str(path), "w", format="matroska", container_options=BIT_EXACT) as file:
        stream = file.add_stream("ffv1", rate=rate, options=OPTIONS)
        stream.width, stream.height, stream.pix_fmt = frames.width, frames.height, stored
        stream.codec_context.flags |= av.codec.context.Flags.bitexact
        for _first, piece in pieces(frames):
            for frame in piece:
                picture = av.VideoFrame.from_ndarray(frame, format=given)
                file.mux(stream.encode(picture.reformat(format=stored)))
        file.mux(stream.encode(None))


FORMAT = Format(
    name="ffv1",
    says="lossless video, FFV1 in Matroska, one file a shot",
    media_type="video/matroska",
    reading="import av; frames = [f.to_ndarray() for f in av.open(FILE).decode(video=0)]",
    pixels=EVERY_KIND,
    write=one_file_a_shot("mkv", save),
    stack="{label}.mkv",
)
