"""Where the panels of a colour chart are in a frame: found by OpenCV, or given.

OpenCV's detector looks for the 24 patches of a ColorChecker by their outlines and colours; of each
patch about the middle half is taken, which leaves a quarter of its side for the detector's error. A
picture of what was found is written, for somebody to look at: a detector may be wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.library import library
from foundation.panel import Panel

PATCHES = 24
SHARE = 0.4
"""Side of a panel by the distance from patch to patch; a patch has 0.8 to 0.9 of it."""

GAMMA = 2.2
WHITE_PERCENTILE = 99.5
"""How frames are made to look like pictures, which the detector knows."""

REMEDY = "give them by --panel NAME=X,Y,W,H, or --panels none"


def picture(frames: NDArray[Any], cfa: str | None) -> NDArray[np.uint8]:
    """The mean of some frames as a picture to look at: (h, w, 3), at half size for a mosaic."""
    mean = np.asarray(frames, dtype=np.float64).mean(axis=0)
    if mean.ndim == 2 and cfa is not None:
        sites: dict[str, list[NDArray[Any]]] = {}
        h, w = mean.shape[0] // 2 * 2, mean.shape[1] // 2 * 2
        for k, colour in enumerate(cfa):
            sites.setdefault(colour, []).append(mean[k // 2 : h : 2, k % 2 : w : 2])
        blank = [np.zeros((h // 2, w // 2))]
        mean = np.stack([np.mean(sites.get(c, blank), axis=0) for c in "RGB"], axis=-1)
    if mean.ndim == 2:
        mean = np.repeat(mean[..., None], 3, axis=2)
    low, high = np.percentile(mean, 100 - WHITE_PERCENTILE), np.percentile(mean, WHITE_PERCENTILE)
    scaled = np.clip((mean - low) / max(high - low, 1e-9), 0, 1)
    return np.asarray(np.rint(255 * scaled ** (1 / GAMMA)), dtype=np.uint8)


def detect(shown: NDArray[np.uint8], scale: int) -> tuple[Panel, ...]:
    """The 24 panels of the chart in a picture, row by row from the brown patch.

    Args:
        shown: the picture.
        scale: pixels of the frame to one of the picture.

    Raises:
        ExchangeError: when there is no chart, or only a part of one.
    """
    cv2 = library("cv2", "to find a chart")
    if not hasattr(cv2, "mcc"):
        raise ExchangeError(
            f"OpenCV {cv2.__version__} has no detector of charts",
            "expected version 5, or one with the contributed modules",
            REMEDY,
        )
    detector = cv2.mcc.CCheckerDetector.create()
    detector.setColorChartType(cv2.mcc.MCC24)
    detector.setDetectionParams(cv2.mcc.DetectorParametersMCC())
    if not detector.process(np.ascontiguousarray(shown[..., ::-1]), 1):
        raise ExchangeError("no colour chart was found", "expected all its 24 patches", REMEDY)
    corners = np.asarray(detector.getBestColorChecker().getColorCharts(), dtype=np.float64)
    if corners.shape != (4 * PATCHES, 2):
        raise ExchangeError(f"a chart of {len(corners) // 4} patches", "expected 24", REMEDY)
    centres = scale * corners.reshape(PATCHES, 4, 2).mean(axis=1)
    pitch = min(
        np.linalg.norm(np.diff(centres.reshape(4, 6, 2), axis=axis), axis=2).min()
        for axis in (0, 1)
    )
    size = int(SHARE * pitch) // 2 * 2
    height, width = scale * shown.shape[0], scale * shown.shape[1]
    panels = []
    for number, (x, y) in enumerate(centres, start=1):
        left, top = round(x - size / 2), round(y - size / 2)
        if size < 2 or left < 0 or top < 0 or left + size > width or top + size > height:
            raise ExchangeError(
                f"patch {number} of the chart found lies at the edge of the frame",
                "expected all of it inside",
                REMEDY,
            )
        panels.append(Panel(name=str(number), x=left, y=top, w=size, h=size))
    return tuple(panels)


def overlay(path: Path, shown: NDArray[np.uint8], panels: Sequence[Panel], scale: int) -> None:
    """Write the picture with the panels drawn over it."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(shown)
    draw = ImageDraw.Draw(image)
    for panel in panels:
        x, y = panel.x / scale, panel.y / scale
        box = (x, y, x + panel.w / scale, y + panel.h / scale)
        draw.rectangle(box, outline=(255, 0, 0))
        draw.text((x + 2, y + 1), panel.name, fill=(255, 0, 0))
    image.save(path, format="PNG")


def parse(words: Sequence[str]) -> tuple[Panel, ...]:
    """``NAME=X,Y,W,H`` each.

    Raises:
        ExchangeError: for a word of another form.
    """
    panels = []
    for word in words:
        name, _, text = word.partition("=")
        parts = text.split(",")
        if not name or len(parts) != 4 or not all(part.strip().isdecimal() for part in parts):
            raise ExchangeError(
                f"--panel {word}",
                "expected NAME=X,Y,W,H in pixels",
                "as in --panel 19=40,390,50,50",
            )
        x, y, w, h = (int(part) for part in parts)
        if w < 1 or h < 1:
            raise ExchangeError(f"--panel {word}", "expected W and H of 1 or more", "correct it")
        panels.append(Panel(name=name, x=x, y=y, w=w, h=h))
    return tuple(panels)
