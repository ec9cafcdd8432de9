"""PNG, TIFF, FITS and NPY: pixels by the readers of the capture folder, exposure from the header.

EXIF: tag 33434 ExposureTime in s, 272 Model. FITS: EXPTIME or EXPOSURE in s, CCD-TEMP in degrees
Celsius, INSTRUME, BAYERPAT.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.reader import Header, Reader, Roll, positive
from foundation.quiet import quiet
from sensor.capture_folder import inside
from sensor.stack_files import ENDINGS, read_stack

EXPOSURE_TIME, MODEL, EXIF_FOLDER = 33434, 272, 34665


def read(path: Path) -> Roll:
    """A file's frames and what its header says.

    Raises:
        CaptureError: when it is damaged, larger than the limit, or no image.
        ExchangeError: for samples that are neither 8 nor 16 bits.
    """
    if set(path.name) & set("*?["):
        raise ExchangeError(
            f"the name {path.name} holds one of * ? [", "expected a plain name", "rename the file"
        )
    ending = path.suffix.lower()
    stack = read_stack(path.parent, path.name, inside)
    with quiet(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about tags that have nothing to do with exposure
        try:
            told = HEADERS.get(ending, _nothing)(path)
        except Exception as problem:
            # The pixels could be read, its header cannot: three libraries raise what they like.
            raise ExchangeError(
                f"cannot read the header of {path} ({problem})",
                "expected a whole one",
                "copy the file again",
            ) from None
    return Roll(
        told=told,
        frames=iter(_unsigned(path, stack)),
        several=ending == ".npy" or len(stack) > 1,
    )


def _unsigned(path: Path, stack: NDArray[Any]) -> NDArray[Any]:
    """8 or 16 bits without a sign; signed whole numbers that hold nothing negative will do."""
    kind = stack.dtype
    if kind in (np.uint8, np.uint16):
        return stack
    if kind.kind in "iu" and stack.ndim >= 3 and stack.size and int(stack.min()) >= 0:
        largest = int(stack.max())
        if largest < 2**16:
            return stack.astype(np.uint16)
    raise ExchangeError(
        f"{path} holds {kind} samples", "expected whole numbers of 8 or 16 bits", "convert it"
    )


def _nothing(_: Path) -> Header:
    return Header()


def _exif(path: Path) -> Header:
    from PIL import Image

    with Image.open(path) as image:
        tags = image.getexif()
        exposure = tags.get_ifd(EXIF_FOLDER).get(EXPOSURE_TIME, tags.get(EXPOSURE_TIME))
        return Header(where="EXIF", exposure_s=positive(exposure), camera=_text(tags.get(MODEL)))


def _tiff(path: Path) -> Header:
    import tifffile

    with tifffile.TiffFile(path) as file:
        tags = file.pages[0].tags
        exif = tags.get(EXIF_FOLDER)
        inner = exif.value.get("ExposureTime") if exif and isinstance(exif.value, dict) else None
        outer = tags.get(EXPOSURE_TIME)
        exposure = inner if inner is not None else outer.value if outer else None
        model = tags.get(MODEL)
        return Header(
            where="EXIF",
            exposure_s=_ratio(exposure),
            camera=_text(model.value if model else None),
        )


def _ratio(value: Any) -> float | None:
    if isinstance(value, tuple) and len(value) == 2 and value[1]:
        return positive(value[0] / value[1])
    return positive(value)


def _fits(path: Path) -> Header:
    from astropy.io import fits

    header = fits.getheader(path)
    pattern = _text(header.get("BAYERPAT"))
    temperature = header.get("CCD-TEMP")
    return Header(
        where="FITS header",
        exposure_s=positive(header.get("EXPTIME", header.get("EXPOSURE"))),
        temperature_c=float(temperature) if isinstance(temperature, (int, float)) else None,
        camera=_text(header.get("INSTRUME")),
        cfa=pattern if pattern and len(pattern) == 4 and set(pattern) <= set("RGB") else None,
    )


def _text(value: Any) -> str | None:
    text = " ".join(str(value).split()) if value is not None else ""
    return text[:100] or None


HEADERS: dict[str, Callable[[Path], Header]] = {
    ".png": _exif,
    ".tif": _tiff,
    ".tiff": _tiff,
    ".fits": _fits,
    ".fit": _fits,
}
"""What reads the header; the other files that `sensor.stack_files` reads have none."""

READER = Reader(name="images", read=read, endings=ENDINGS)
