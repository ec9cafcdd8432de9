"""The rate image: mean photo-electrons per second in each pixel under each colour filter.

It is light alone, at lamp level 1, free of every sensor effect: electrons = rate x level x
exposure. On disk it is an OpenEXR file of 32-bit floats: channels ``R``, ``G``, ``B`` hold the
rate, ``R.var``, ``G.var``, ``B.var`` the variance of that mean from the finite number of light
paths, and the header's string attribute ``camtruth`` a JSON object with where it came from.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import OpenEXR
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from foundation.documents import STRICT, convert, parse_json
from foundation.errors import DocumentError
from foundation.output import new_file
from foundation.panel import Panel
from foundation.quiet import quiet
from render.errors import RenderError
from scenes.spectra import CHANNELS

ATTRIBUTE = "camtruth"
VARIANCE = ".var"
MAX_SIDE_PX = 8192
"""A longer side is a mistake or an attack: such an image would take gigabytes."""

ANEW = "render it again, or choose another file"


@dataclass(frozen=True, kw_only=True)
class RateHeader:
    """Where a rate image came from.

    Attributes:
        scene, lamp: their names.
        optics: the lens as numbers and words, and how it was computed (`renderer`).
        samples: light paths per pixel; 0 for a closed form.
        seed: of the light paths.
        versions: of the programs that made it.
        panels: the areas of the image that show one panel alone, clear of its blurred edges.
        noise: relative standard error in the noisiest of the grey panels, per channel.
    """

    scene: str
    lamp: str
    optics: dict[str, float | str] = field(default_factory=dict)
    samples: Annotated[int, Field(ge=0)] = 0
    seed: Annotated[int, Field(ge=0)] = 0
    versions: dict[str, str] = field(default_factory=dict)
    panels: tuple[Panel, ...] = ()
    noise: dict[str, float] = field(default_factory=dict)

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True, eq=False)
class RateImage:
    """A rate image in memory; the arrays are read-only float32, (H, W, 3).

    Attributes:
        rate_e_per_s: mean photo-electrons per second, channels R, G, B.
        variance: variance of that mean in (e-/s)^2.
        header: where it came from.
    """

    rate_e_per_s: NDArray[np.float32]
    variance: NDArray[np.float32]
    header: RateHeader

    def panel(self, name: str) -> Panel:
        """A panel of the header by name.

        Raises:
            RenderError: when the image does not show it.
        """
        for panel in self.header.panels:
            if panel.name == name:
                return panel
        known = ", ".join(p.name for p in self.header.panels) or "none"
        raise RenderError(
            f"no panel '{name}' in the rate image", f"expected one of {known}", "choose another"
        )


def rate_image(rate_e_per_s: ArrayLike, variance: ArrayLike, header: RateHeader) -> RateImage:
    """A rate image, checked.

    Raises:
        RenderError: for a wrong shape, NaN, infinite or negative values, or a panel outside.
    """
    return _checked(rate_e_per_s, variance, header, "the rate image")


def _checked(rate: ArrayLike, variance: ArrayLike, header: RateHeader, source: str) -> RateImage:
    arrays = []
    for what, values in (("rate", rate), ("variance", variance)):
        array = np.array(values, dtype=np.float32)
        if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
            raise RenderError(
                f"{what} of shape {array.shape} in {source}", "expected (H, W, 3)", ANEW
            )
        if not np.isfinite(array).all():
            raise RenderError(f"{what} in {source} holds NaN or infinity", "expected numbers", ANEW)
        if (array < 0).any():
            raise RenderError(
                f"{what} in {source} is as low as {array.min():g}", "expected no negative one", ANEW
            )
        array.setflags(write=False)
        arrays.append(array)
    if arrays[0].shape != arrays[1].shape:
        raise RenderError(
            f"{source} has a rate of shape {arrays[0].shape} and a variance of {arrays[1].shape}",
            "expected equal shapes",
            ANEW,
        )
    height, width, _ = arrays[0].shape
    for panel in header.panels:
        if panel.x + panel.w > width or panel.y + panel.h > height:
            raise RenderError(
                f"panel '{panel.name}' in {source} ends at column {panel.x + panel.w}, row"
                f" {panel.y + panel.h}",
                f"expected it inside {width} x {height} px",
                ANEW,
            )
    return RateImage(rate_e_per_s=arrays[0], variance=arrays[1], header=header)


def write_rate(path: Path, image: RateImage) -> None:
    """Write a rate image; an existing file is replaced whole.

    Raises:
        OutputError: when the place cannot be written.
    """
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        ATTRIBUTE: json.dumps(dataclasses.asdict(image.header)),
    }
    channels = {}
    for index, name in enumerate(CHANNELS):
        channels[name] = np.ascontiguousarray(image.rate_e_per_s[..., index])
        channels[name + VARIANCE] = np.ascontiguousarray(image.variance[..., index])
    with new_file(path) as scratch:
        try:
            OpenEXR.File(header, channels).write(str(scratch))
        except RuntimeError as problem:
            raise OSError(str(problem)) from None


def read_rate(path: Path) -> RateImage:
    """Read a rate image strictly.

    Raises:
        RenderError: for a file that is missing, truncated, no OpenEXR, too large, lacks a channel
            or the header attribute, or holds values that no rate image can.
    """
    path = Path(path)
    if not path.is_file():
        raise RenderError(f"no file {path}", "expected a rate image (.exr)", "check the path")
    header, channels = _read_parts(path, header_only=True)
    _refuse_size(path, header)
    attribute = header.get(ATTRIBUTE)
    if not isinstance(attribute, str):
        raise RenderError(
            f"no header attribute '{ATTRIBUTE}' in {path}", "expected a camtruth rate image", ANEW
        )
    source = f"the header of {path}"
    try:
        meaning = convert(parse_json(attribute, source), RateHeader, source)
    except DocumentError as problem:
        raise RenderError(problem.found, problem.expected, ANEW) from None
    _, channels = _read_parts(path, header_only=False)
    planes: dict[str, NDArray[np.float32]] = {}
    for name in [c + suffix for suffix in ("", VARIANCE) for c in CHANNELS]:
        if name not in channels:
            found = ", ".join(sorted(channels)) or "none"
            raise RenderError(
                f"no channel '{name}' in {path} (channels: {found})",
                f"expected {', '.join(CHANNELS)} and {', '.join(c + VARIANCE for c in CHANNELS)}",
                ANEW,
            )
        plane = channels[name].pixels
        if plane is None or plane.dtype != np.float32 or plane.ndim != 2:
            raise RenderError(f"channel '{name}' in {path} is not float32", "expected it", ANEW)
        planes[name] = plane
    shapes = {plane.shape for plane in planes.values()}
    if len(shapes) > 1:
        raise RenderError(f"channels of unequal size in {path}", "expected equal ones", ANEW)
    return _checked(
        np.stack([planes[c] for c in CHANNELS], axis=-1),
        np.stack([planes[c + VARIANCE] for c in CHANNELS], axis=-1),
        meaning,
        str(path),
    )


_ONE_READER = threading.Lock()


def _read_parts(path: Path, *, header_only: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and channels of the only part; whatever OpenEXR throws becomes one line."""
    try:
        # OpenEXR prints its own complaints about a damaged file, from Python on standard output and
        # from C on standard error. There is one standard output for all threads: two that redirect
        # it at once would leave it redirected.
        with (
            _ONE_READER,
            quiet(),
            contextlib.redirect_stdout(io.StringIO()),
            OpenEXR.File(str(path), separate_channels=True, header_only=header_only) as file,
        ):
            if not file.parts:
                raise RenderError(
                    f"cannot read the pixels of {path}", "expected a whole OpenEXR file", ANEW
                )
            if len(file.parts) != 1:
                raise RenderError(f"{path} has {len(file.parts)} parts", "expected one", ANEW)
            return dict(file.header()), dict(file.channels())
    except RenderError:
        raise
    except Exception as problem:
        detail = str(problem).splitlines()[0][:120] if str(problem) else type(problem).__name__
        raise RenderError(
            f"cannot read {path} ({detail})", "expected a whole OpenEXR file", ANEW
        ) from None


def _refuse_size(path: Path, header: dict[str, Any]) -> None:
    """Look at the size that the header claims before anything of that size is made."""
    low, high = header["dataWindow"]
    width, height = (int(high[axis]) - int(low[axis]) + 1 for axis in (0, 1))
    if not (1 <= width <= MAX_SIDE_PX and 1 <= height <= MAX_SIDE_PX):
        raise RenderError(
            f"{path} claims {width} x {height} px",
            f"expected at most {MAX_SIDE_PX} x {MAX_SIDE_PX}",
            ANEW,
        )
