"""EXR for rate images: the light alone, 32-bit floats, channels R, G, B and their variances."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.format import EVERY_KIND, Format, FrameFile, once
from camtruth.exchange.source import Source
from sensor.capture_folder import inside


def write(folder: Path, source: Source) -> Iterator[FrameFile]:
    """Write the rate image of every lamp of the capture.

    Raises:
        ExchangeError: when it has none.
    """
    if not source.rate_files:
        raise ExchangeError(
            f"no rate image in {source.folder}",
            "expected one: EXR is for the light, not for frames",
            "choose another --format",
        )
    for lamp in source.rates:
        name = f"rate-{lamp}.exr"
        light = inside(source.folder, source.rate_files[lamp])
        kept = once(folder / name, partial(shutil.copyfile, light))
        shot = next(shot for shot in source.document.shot if shot.light == (lamp,))
        yield FrameFile(name=name, shot=shot.label, first=0, count=0, kept=kept)


FORMAT = Format(
    name="exr",
    says="OpenEXR of the rate images alone, electrons per second in 32-bit floats",
    media_type="image/x-exr",
    reading="import OpenEXR; rgb = OpenEXR.File(FILE).channels()['RGB'].pixels",
    pixels=EVERY_KIND,
    write=write,
)
