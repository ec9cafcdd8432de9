"""Frames of a mosaic whose colours were filled in by means of neighbours, without any camera."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from analysis.gap.look.lattices import Lattice
from sensor.demosaicers import colour_demosaicing
from sensor.frames import Capture, Frames
from sensor.protocol import Shot

MOSAIC = tuple(
    Lattice(name=name, channel=name[0], dy=dy, dx=dx, step=2)
    for name, dy, dx in (("R", 0, 0), ("G1", 0, 1), ("G2", 1, 0), ("B", 1, 1))
)


def filled_in(raw: np.ndarray) -> np.ndarray:
    """A mosaic RGGB with the colours between filled in by means of neighbours."""
    y, x = np.mgrid[: raw.shape[1], : raw.shape[2]]
    red, blue = (y % 2 == 0) & (x % 2 == 0), (y % 2 == 1) & (x % 2 == 1)
    cross = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 4
    square = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 4
    planes = [
        ndimage.convolve(raw * here, kernel[None], mode="mirror")
        for here, kernel in ((red, square), (~red & ~blue, cross), (blue, square))
    ]
    return np.stack(planes, axis=-1)


def lit(dn: np.ndarray, pixels: str) -> Frames:
    """A shot of whole codes."""
    shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=0.01, frames=len(dn))
    codes = np.clip(np.round(dn), 0, 255).astype(np.uint8)
    return Frames(shot=shot, dn=codes, pixels=pixels, bits=8, cfa=None)


def colour_capture(cfa: str, seed: int = 4) -> Capture:
    """Frames as a bilinear demosaicer makes them: neighbours of a measured sample are means."""
    fill = colour_demosaicing().demosaicing_CFA_Bayer_bilinear
    rng = np.random.default_rng(seed)
    raw = rng.normal(60, 4, (8, 64, 64)).astype(np.float32)
    frames = np.array([fill(frame, cfa) for frame in raw])
    dn = np.clip(np.round(frames), 0, 255).astype(np.uint8)
    shot = Shot(label="a", light=("lamp",), exposure_s=0.01, frames=8)
    return Capture(camera="x", frames=(Frames(dn=dn, shot=shot, pixels="rgb8", bits=8),))
