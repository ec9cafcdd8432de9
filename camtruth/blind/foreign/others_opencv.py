"""OpenCV's own demosaicers, filters, resampling and colour spaces."""

from __future__ import annotations

import cv2
import numpy as np

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

SOURCE = "opencv"
MOSAICS = {"RGGB", "BGGR", "GRBG", "GBRG"}


def demosaic(mosaic: Numbers, strength: float, about: About) -> Numbers:
    """Edge-aware filling by OpenCV, on 16-bit codes scaled up from DN."""
    scale = 2.0 ** (16 - about.bits)
    codes = np.clip(np.round(mosaic * scale), 0, 65535).astype(np.uint16)
    code = getattr(cv2, f"COLOR_BAYER_{about.cfa}2RGB_EA")
    return np.stack([cv2.cvtColor(frame, code) for frame in codes]).astype(np.float32) / scale


def blurred(image: Numbers, strength: float, about: About) -> Numbers:
    """Denoise: mixed with its Gaussian blur of 0.9 pixels, by `strength`."""
    return _each(image, lambda f: cv2.addWeighted(f, 1 - strength, _soft(f, 0.9), strength, 0.0))


def bilateral(image: Numbers, strength: float, about: About) -> Numbers:
    """Denoise by a bilateral filter of 5 x 5 whose tone range is `strength` DN."""
    return _each(image, lambda f: cv2.bilateralFilter(f, 5, strength, 1.2))


def unsharp(image: Numbers, strength: float, about: About) -> Numbers:
    """Sharpening: `strength` times the difference from a Gaussian blur of 1 pixel is added."""
    return _each(image, lambda f: cv2.addWeighted(f, 1 + strength, _soft(f, 1.0), -strength, 0.0))


def distorted(rate: Numbers, strength: float, about: About) -> Numbers:
    """Radial distortion: the corner's square distance is 1, `strength` its cubic coefficient."""
    height, width = rate.shape[1:3]
    half = np.hypot(height / 2, width / 2)
    camera = np.array([[half, 0, (width - 1) / 2], [0, half, (height - 1) / 2], [0, 0, 1.0]])
    ways = cv2.initUndistortRectifyMap(
        camera, np.array([strength, 0, 0, 0]), np.eye(3), camera, (width, height), cv2.CV_32FC1
    )
    return _each(
        rate,
        lambda f: cv2.remap(f, *ways, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE),
    )


def lateral_colour(rate: Numbers, strength: float, about: About) -> Numbers:
    """Red is larger and blue smaller than green, by `strength` pixels at the corner."""
    height, width = rate.shape[1:3]
    half = np.hypot(height / 2, width / 2)
    out = rate.astype(np.float32).copy()
    for channel, sign in ((0, 1.0), (2, -1.0)):
        s = 1 - sign * strength / half
        x, y = (1 - s) * (width - 1) / 2, (1 - s) * (height - 1) / 2
        matrix = np.array([[s, 0, x], [0, s, y]])
        for k, frame in enumerate(rate[..., channel].astype(np.float32)):
            out[k, ..., channel] = cv2.warpAffine(
                np.ascontiguousarray(frame),
                matrix,
                (width, height),
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                borderMode=cv2.BORDER_REPLICATE,
            )
    return out


def chroma(codes: Numbers, strength: float, about: About) -> Numbers:
    """Y Cr Cb by OpenCV, chroma at half the rows and columns, back by linear interpolation."""
    height, width = codes.shape[1:3]
    out = []
    for frame in np.clip(codes, 0, 255).astype(np.uint8):
        y, cr, cb = cv2.split(cv2.cvtColor(frame, cv2.COLOR_RGB2YCrCb))
        small = [cv2.resize(c, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
                 for c in (cr, cb)]  # fmt: skip
        large = [cv2.resize(c, (width, height), interpolation=cv2.INTER_LINEAR) for c in small]
        out.append(cv2.cvtColor(cv2.merge([y, *large]), cv2.COLOR_YCrCb2RGB))
    return np.stack(out).astype(codes.dtype)


def _soft(frame: Numbers, sigma_px: float) -> Numbers:
    return np.asarray(cv2.GaussianBlur(frame, (0, 0), sigma_px))


def _each(stack: Numbers, change: object) -> Numbers:
    frames = np.ascontiguousarray(stack, dtype=np.float32)
    return np.stack([np.asarray(change(f), dtype=np.float32) for f in frames])  # type: ignore[operator]


def _by(name: str, answers: tuple[str, ...], stage: str, place: str, ends: tuple[float, float],
        act: object, *, choice: bool = False, order: int = 50) -> Outsider:  # fmt: skip
    return Outsider(
        name=f"opencv {name}",
        source=SOURCE,
        answers=answers,
        stage=stage,
        place=place,  # type: ignore[arg-type]
        weakest=ends[0],
        strongest=ends[1],
        act=act,  # type: ignore[arg-type]
        choice=choice,
        order=order,
    )


OUTSIDERS = (
    _by("edge-aware", ("demosaic_other",), "processing", "demosaic", (1, 1), demosaic, choice=True),
    _by("blur", ("spatial_denoise",), "processing", "image", (0.005, 0.9), blurred, order=40),
    _by("bilateral", ("spatial_denoise",), "processing", "image", (0.3, 30.0), bilateral, order=40),
    _by("unsharp", ("sharpening",), "processing", "image", (0.005, 3.0), unsharp, order=60),
    _by("distortion", ("lens_distortion",), "optics", "rate", (1e-4, 0.2), distorted, order=20),
    _by("lateral colour", ("lateral_chromatic_aberration",), "optics", "rate", (0.01, 5.0),
        lateral_colour, order=30),
    _by("chroma", ("chroma_subsampling",), "transport", "codes", (1, 1), chroma, choice=True,
        order=10),
)  # fmt: skip
