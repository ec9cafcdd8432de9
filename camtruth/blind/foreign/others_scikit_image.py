"""Denoise and sharpening of scikit-image."""

from __future__ import annotations

import numpy as np
from skimage.filters import unsharp_mask
from skimage.restoration import denoise_tv_chambolle

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

SOURCE = "scikit-image"


def total_variation(image: Numbers, strength: float, about: About) -> Numbers:
    """Chambolle's total-variation denoise; its weight is `strength` thousandths of full scale."""
    scale = float(about.top_dn)
    frames = [
        denoise_tv_chambolle(f / scale, weight=strength / 1000, max_num_iter=30, channel_axis=-1)
        for f in image.astype(np.float64)
    ]
    return (np.stack(frames) * scale).astype(np.float32)


def sharpened(image: Numbers, strength: float, about: About) -> Numbers:
    """Unsharp mask of radius 1 and amount `strength`, colour by colour."""
    out = np.empty(image.shape, dtype=np.float32)
    for k, frame in enumerate(image.astype(np.float64)):
        for c in range(3):
            plane = np.ascontiguousarray(frame[..., c])
            out[k, ..., c] = unsharp_mask(plane, radius=1.0, amount=strength, preserve_range=True)
    return out


def _by(name: str, answer: str, ends: tuple[float, float], act: object, order: int) -> Outsider:
    return Outsider(
        name=f"scikit-image {name}",
        source=SOURCE,
        answers=(answer,),
        stage="processing",
        place="image",
        weakest=ends[0],
        strongest=ends[1],
        act=act,  # type: ignore[arg-type]
        order=order,
    )


OUTSIDERS = (
    _by("total variation", "spatial_denoise", (0.05, 30.0), total_variation, 40),
    _by("unsharp mask", "sharpening", (0.005, 3.0), sharpened, 60),
)
