"""What no catalogue has, after conversion: in the mosaic, the image, the codes and on the cable."""

from __future__ import annotations

import numpy as np

from camtruth.blind.foreign.outsider import About, Numbers, Outsider, Place

LEAST_OF_FRAMES = 0.05
"""Of the 216 frames of a case eleven have such an event on average, and one case in 50,000 none: a
case without any is a null."""


def green_imbalance(mosaic: Numbers, strength: float, about: About) -> Numbers:
    """Green in the rows of red is brighter than green in the rows of blue, by `strength`."""
    height, width = mosaic.shape[1:]
    sites = about.sites(height, width)
    red_rows = (sites == 0).any(axis=1)
    more = np.where(red_rows[:, None] & (sites == 1), 1 + strength, 1.0)
    return np.asarray((mosaic - about.black_dn) * more + about.black_dn, dtype=mosaic.dtype)


def lens_shading_correction(mosaic: Numbers, strength: float, about: About) -> Numbers:
    """A gain that rises with the square of the distance from the centre, noise and all."""
    height, width = mosaic.shape[1:]
    row = (np.arange(height) - (height - 1) / 2)[:, None]
    column = (np.arange(width) - (width - 1) / 2)[None]
    r2 = (row**2 + column**2) / ((height / 2) ** 2 + (width / 2) ** 2)
    lifted = (mosaic - about.black_dn) * (1 + strength * r2) + about.black_dn
    return np.asarray(lifted, dtype=mosaic.dtype)


def false_colour_suppression(image: Numbers, strength: float, about: About) -> Numbers:
    """Median of 3 x 3 over the differences of colour, mixed in by `strength`."""
    green = image[..., 1:2]
    chroma = image - green
    wide = np.pad(chroma, ((0, 0), (1, 1), (1, 1), (0, 0)), mode="edge")
    height, width = image.shape[1:3]
    nine = [wide[:, i : i + height, j : j + width] for i in range(3) for j in range(3)]
    calm = np.median(np.stack(nine), axis=0)
    return np.asarray(green + (1 - strength) * chroma + strength * calm, dtype=image.dtype)


def rescaling(image: Numbers, strength: float, about: About) -> Numbers:
    """Scaled down by 1 + `strength` and up again, linearly: a comb of sharp and soft columns."""
    out = image
    for axis in (1, 2):
        out = _resized(out, axis, max(2, round(out.shape[axis] / (1 + strength))))
        out = _resized(out, axis, image.shape[axis])
    return np.asarray(out, dtype=image.dtype)


def _resized(values: Numbers, axis: int, length: int) -> Numbers:
    have = values.shape[axis]
    at = np.clip((np.arange(length) + 0.5) * have / length - 0.5, 0, have - 1)
    low = np.minimum(at.astype(int), have - 2)
    part = (at - low).reshape([-1 if k == axis else 1 for k in range(values.ndim)])
    return np.asarray(
        np.take(values, low, axis) * (1 - part) + np.take(values, low + 1, axis) * part
    )


def companding(codes: Numbers, strength: float, about: About) -> Numbers:
    """A look-up table to fewer levels, spaced as the root, and back; `strength` 1 keeps 1 in 8."""
    levels = about.top_dn / (1 + 7 * strength)
    x = np.arange(about.top_dn + 1) / about.top_dn
    table = np.round(about.top_dn * (np.round(np.sqrt(x) * levels) / levels) ** 2)
    return np.asarray(np.clip(table, 0, about.top_dn)[codes.astype(np.intp)], dtype=codes.dtype)


def tearing(codes: Numbers, strength: float, about: About) -> Numbers:
    """A frame is handed over before it is written: below some row stands the frame before it.

    `strength` is the share of the frames that are torn.
    """
    out = codes.copy()
    for k, draw in enumerate(about.draws("tearing")):
        torn, row = draw.random() < strength, draw.integers(codes.shape[1])
        if k and torn:
            out[k, row:] = codes[k - 1, row:]
    return out


def packet_errors(codes: Numbers, strength: float, about: About) -> Numbers:
    """Bits flip in bursts of up to 64 neighbouring samples, `strength` bursts in a frame."""
    out = codes.copy()
    flat = out.reshape(len(out), -1)
    for frame, draw in zip(flat, about.draws("packet errors"), strict=True):
        for _ in range(draw.poisson(strength)):
            start = int(draw.integers(frame.size))
            run = frame[start : start + int(draw.integers(1, 65))]
            flipped = run.astype(np.int64) ^ (1 << draw.integers(about.bits, size=run.size))
            run[:] = np.where(draw.random(run.size) < 0.25, flipped, run)
    return out


def interlaced(codes: Numbers, strength: float, about: About) -> Numbers:
    """Odd rows arrive one frame late, in a share `strength` of the frames."""
    out = codes.copy()
    for k, draw in enumerate(about.draws("interlaced")):
        if k and draw.random() < strength:
            out[k, 1::2] = codes[k - 1, 1::2]
    return out


def _own(name: str, act: object, place: Place, ends: tuple[float, float], order: int) -> Outsider:
    return Outsider(
        name=name,
        source="none",
        answers=(),
        stage="transport" if place == "codes" else "processing",
        place=place,
        weakest=ends[0],
        strongest=ends[1],
        act=act,  # type: ignore[arg-type]
        order=order,
    )


OUTSIDERS = (
    _own("green_imbalance", green_imbalance, "mosaic", (1e-4, 0.1), 3),
    _own("lens_shading_correction", lens_shading_correction, "mosaic", (1e-3, 2.0), 4),
    _own("false_colour_suppression", false_colour_suppression, "image", (0.01, 1.0), 25),
    _own("rescaling", rescaling, "image", (0.01, 1.0), 70),
    _own("companding", companding, "codes", (0.01, 1.0), 5),
    _own("tearing", tearing, "codes", (LEAST_OF_FRAMES, 1.0), 31),
    _own("late_field", interlaced, "codes", (LEAST_OF_FRAMES, 1.0), 32),
    _own("packet_errors", packet_errors, "codes", (LEAST_OF_FRAMES, 50.0), 33),
)
