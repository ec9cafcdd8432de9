"""The pictures of the report, as data that stands in the page itself."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foundation.panel import Panel
from render.preview import balanced, png, srgb
from render.rate import RateImage
from sensor.frames import Capture, Frames

MAGNIFIED = 6
SPREAD = 4.0
"""A magnified panel shows this many standard deviations either side of grey."""


def data_url(pixels: NDArray[np.uint8]) -> str:
    """A PNG that needs no file."""
    return "data:image/png;base64," + base64.b64encode(png(pixels)).decode("ascii")


SCALES = (1, 2, 5, 10, 20, 50, 100, 200, 500)
"""By which a difference is multiplied to be seen."""

SEEN_DN = 110.0
"""As far from grey as a difference is made to be."""


def magnified_change(change: NDArray[np.float64]) -> tuple[NDArray[np.uint8], int]:
    """A difference of frames in DN as a picture about grey, and how many times it is magnified."""
    spread = float(np.percentile(np.abs(change), 99) or np.abs(change).max() or 1.0)
    times = max((s for s in SCALES if s * spread <= SEEN_DN), default=1)
    return np.asarray(np.clip(128 + times * change, 0, 255), dtype=np.uint8), times


def rendered(images: Mapping[str, RateImage], panels: tuple[Panel, ...]) -> list[dict[str, Any]]:
    """Each rate image to look at, with the analysed areas to outline."""
    return [
        {
            "url": data_url(balanced(image)),
            "lamp": lamp,
            "width": image.rate_e_per_s.shape[1],
            "height": image.rate_e_per_s.shape[0],
            "panels": panels,
            "samples": image.header.samples,
            "noise": max(image.header.noise.values(), default=0.0),
        }
        for lamp, image in images.items()
    ]


def frames(capture: Capture) -> list[dict[str, str]]:
    """One frame of the brightest shot of each lamp, and a dark one with its contrast raised."""
    shown: list[dict[str, str]] = []
    brightest: dict[tuple[str, ...], Frames] = {}
    for stack in capture.lit:
        known = brightest.get(stack.shot.light)
        if known is None or sum(stack.shot.level) > sum(known.shot.level):
            brightest[stack.shot.light] = stack
    for stack in brightest.values():
        picture = srgb(_rgb(stack.dn[0]) / stack.top_dn)
        shown.append({"url": data_url(picture), "text": f"Frame 1 of “{stack.shot.label}”"})
    for stack in capture.darks[-1:]:
        frame = _rgb(stack.dn[0]).astype(np.float64)
        top = max(float(np.percentile(frame, 99.9)), 1.0)
        text = f"Frame 1 of “{stack.shot.label}”, 0 to {top:.0f} DN stretched to the whole range"
        shown.append({"url": data_url(srgb(frame / top)), "text": text})
    return shown


def magnified(capture: Capture) -> list[dict[str, str]]:
    """The middle grey panel of a lit shot taken apart: a frame, its noise in time, its pattern."""
    if not capture.lit:
        return []
    stack = max(capture.lit, key=lambda one: sum(one.shot.level))
    panel = capture.areas[len(capture.areas) // 2]
    samples = stack.dn[:, panel.window[0], panel.window[1]].astype(np.float64)
    mean = samples.mean(axis=0)
    smooth = _columns_fit(mean)
    parts = {
        "one frame": samples[0] - smooth,
        "what changes from frame to frame": samples[0] - mean,
        f"what stays, in the mean of {len(samples)} frames": mean - smooth,
    }
    shown = []
    for text, values in parts.items():
        spread = float(values.std())
        scaled = np.clip(0.5 + values / (2 * SPREAD * spread) if spread else values + 0.5, 0, 1)
        large = np.kron(np.round(255 * _rgb(scaled)), np.ones((MAGNIFIED, MAGNIFIED, 1)))
        picture = data_url(np.asarray(large, dtype=np.uint8))
        shown.append({"url": picture, "text": f"{text}: σ = {spread:.2f} DN"})
    return [{**part, "panel": panel.name, "shot": stack.shot.label} for part in shown]


def _columns_fit(mean: NDArray[np.float64]) -> NDArray[np.float64]:
    """A parabola down every column, as the paper takes out shading."""
    rows = np.linspace(-1, 1, len(mean))
    basis = np.linalg.qr(np.vander(rows, 3))[0]
    flat = mean.reshape(len(mean), -1)
    return np.asarray((basis @ (basis.T @ flat)).reshape(mean.shape))


def _rgb(frame: NDArray[Any]) -> NDArray[Any]:
    """Three equal colours for a frame that has none."""
    return frame if frame.ndim == 3 else np.repeat(frame[..., None], 3, axis=2)
