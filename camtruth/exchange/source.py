"""What is exported: a capture with all that is known of it."""

from __future__ import annotations

import math
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from foundation.documents import parse_json, read_text
from render.rate import RateImage, read_rate
from sensor.capture_folder import (
    MANIFEST,
    TRUTH,
    CaptureDocument,
    ShotDocument,
    inside,
    read_capture,
    read_manifest,
)
from sensor.frames import Capture, Frames
from sensor.protocol import Shot
from sensor.stack_files import files_of
from sensor.truth import FORMAT as TRUTH_FORMAT

NOMINAL_INTERVAL_S = Fraction(1, 15)
"""Frame interval of the paper's camera: written into a video's clock where none is known."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """A capture folder, read and checked.

    Attributes:
        folder: where it lies.
        document: its manifest.
        capture: its frames, on disk until somebody looks at them.
        truth: its truth record; None for a real capture.
    """

    folder: Path
    document: CaptureDocument
    capture: Capture
    truth: Mapping[str, Any] | None

    @property
    def shots(self) -> tuple[tuple[ShotDocument, Frames], ...]:
        """Each shot as the manifest has it, with its frames."""
        return tuple(zip(self.document.shot, self.capture.frames, strict=True))

    @property
    def files(self) -> list[Path]:
        """The manifest and all files that it names, with the truth record."""
        named = [name for shot in self.document.shot for name in (shot.frames, shot.rate) if name]
        found = [self.folder / MANIFEST, self.folder / TRUTH]
        for name in dict.fromkeys(named):
            found += [self.folder / each for each in files_of(self.folder, name)]
        return found

    @property
    def black_dn(self) -> float:
        """Black level where it is known, else 0."""
        return float(self.truth["black_dn"]) if self.truth else 0.0

    @property
    def top_dn(self) -> int:
        """The largest pixel value."""
        return self.capture.frames[0].top_dn

    @cached_property
    def rate_files(self) -> dict[str, str]:
        """Files of the rate images by lamp."""
        known = {}
        for shot in self.document.shot:
            if shot.rate is not None and len(shot.light) == 1:
                inside(self.folder, shot.rate)
                known[shot.light[0]] = shot.rate
        return known

    @cached_property
    def rates(self) -> dict[str, RateImage]:
        """The rate images by lamp."""
        return {
            lamp: read_rate(inside(self.folder, file)) for lamp, file in self.rate_files.items()
        }

    def electrons(self, shot: Shot) -> NDArray[np.float32] | None:
        """Mean photo-electrons of a shot under each colour filter, (H, W, 3); None if unknown.

        Light alone, times the camera's sensitivity: before any effect of the sensor.
        """
        frames = self.capture.frames[0]
        total = np.zeros((frames.height, frames.width, 3), dtype=np.float32)
        if shot.dark:
            return total
        if any(lamp not in self.rates for lamp in shot.light):
            return None
        for lamp, level in zip(shot.light, shot.level, strict=True):
            total += np.float32(level * shot.exposure_s) * self.rates[lamp].rate_e_per_s
        return total * self.sensitivity

    @property
    def sensitivity(self) -> NDArray[np.float32]:
        """Photo-electrons of the camera per photo-electron of the rate image, by colour."""
        figure = self.truth["sensitivity"] if self.truth else 1.0
        three = [figure[c] for c in "RGB"] if isinstance(figure, Mapping) else [figure] * 3
        return np.array(three, dtype=np.float32)

    def copy(self, name: str, folder: Path) -> None:
        """Copy a file of the capture into another folder, under the same name."""
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(inside(self.folder, name), folder / name)


def read_source(folder: Path) -> Source:
    """A capture folder with its truth.

    Raises:
        InputError: when it is none, or its truth record is damaged.
    """
    capture = read_capture(folder)
    path = folder / TRUTH
    truth = parse_json(read_text(path), str(path)) if path.exists() else None
    if truth is not None and not _is_truth(truth):
        from camtruth.exchange.errors import ExchangeError

        raise ExchangeError(
            f"{path} is no truth record",
            f"expected format {TRUTH_FORMAT} with a camera, gain, black level and effects",
            "make the capture anew, or remove the file to export frames alone",
        )
    return Source(folder=folder, document=read_manifest(folder), capture=capture, truth=truth)


def _is_truth(document: Any) -> bool:
    if not isinstance(document, dict) or document.get("format") != TRUTH_FORMAT:
        return False
    figures = document.get("black_dn"), document.get("sensitivity"), document.get("gain_dn_per_e")
    return (
        isinstance(document.get("effects"), list)
        and isinstance(document.get("noise"), dict)
        and isinstance(figures[0], (int, float))
        and math.isfinite(figures[0])
        and all(isinstance(f, (int, float)) or _per_colour(f) for f in figures[1:])
    )


def _per_colour(figure: Any) -> bool:
    return (
        isinstance(figure, dict)
        and set(figure) == set("RGB")
        and all(isinstance(v, (int, float)) for v in figure.values())
    )
