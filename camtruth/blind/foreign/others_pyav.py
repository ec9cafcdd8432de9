"""FFmpeg's codecs through PyAV: a DV tape, and motion JPEG."""

from __future__ import annotations

from fractions import Fraction

import av
import numpy as np

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

SOURCE = "ffmpeg"
DV_ROWS, DV_COLUMNS = 480, 720
"""The one size that a DV tape of 30 frames a second has."""


def dv(codes: Numbers, strength: float, about: About) -> Numbers:
    """To DV and back: 8 x 8 cosines at a fixed rate, chroma at a quarter of the columns."""
    height, width = codes.shape[1:3]
    if height > DV_ROWS or width > DV_COLUMNS:
        return np.concatenate(
            [dv(part, strength, about) for part in np.split(codes, [DV_ROWS], axis=1)], axis=1
        ) if width <= DV_COLUMNS else np.concatenate(
            [dv(part, strength, about) for part in np.split(codes, [DV_COLUMNS], axis=2)], axis=2
        )  # fmt: skip
    frames = np.clip(codes, 0, 255).astype(np.uint8)
    pad = ((0, 0), (0, DV_ROWS - height), (0, DV_COLUMNS - width), (0, 0))
    back = _round_trip(np.pad(frames, pad, mode="wrap"), "dvvideo", "yuv411p", {})
    return back[:, :height, :width].astype(codes.dtype)


def motion_jpeg(codes: Numbers, strength: float, about: About) -> Numbers:
    """To FFmpeg's own motion JPEG and back, at the quantizer `strength`."""
    height, width = codes.shape[1:3]
    frames = np.clip(codes, 0, 255).astype(np.uint8)
    pad = ((0, 0), (0, -height % 16), (0, -width % 16), (0, 0))
    scale = str(max(1, round(strength)))
    back = _round_trip(
        np.pad(frames, pad, mode="edge"), "mjpeg", "yuvj444p", {"qmin": scale, "qmax": scale}
    )
    return back[:, :height, :width].astype(codes.dtype)


def _round_trip(frames: Numbers, codec: str, pixels: str, options: dict[str, str]) -> Numbers:
    encoder = av.CodecContext.create(codec, "w")
    encoder.height, encoder.width = frames.shape[1:3]
    encoder.pix_fmt = pixels
    encoder.time_base = Fraction(1001, 30000)
    encoder.framerate = Fraction(30000, 1001)
    encoder.options = options
    decoder = av.CodecContext.create(codec, "r")
    out = []
    for number, frame in enumerate(frames):
        picture = av.VideoFrame.from_ndarray(frame, format="rgb24").reformat(format=pixels)
        picture.pts = number
        picture.time_base = encoder.time_base
        for packet in encoder.encode(picture):
            out += decoder.decode(packet)
    for packet in encoder.encode(None):
        out += decoder.decode(packet)
    out += decoder.decode(None)
    return np.stack([picture.to_ndarray(format="rgb24") for picture in out])


OUTSIDERS = (
    Outsider(
        name="ffmpeg dv",
        source=SOURCE,
        answers=("jpeg", "chroma_subsampling"),
        stage="transport",
        place="codes",
        weakest=1,
        strongest=1,
        act=dv,
        choice=True,
        order=20,
    ),
    Outsider(
        name="ffmpeg motion jpeg",
        source=SOURCE,
        answers=("jpeg",),
        stage="transport",
        place="codes",
        weakest=1,
        strongest=31,
        act=motion_jpeg,
        order=20,
    ),
)
