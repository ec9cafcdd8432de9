"""What may be wrong with a camera by somebody else, by the formulas that come to mind first.

Each fault has the name of an effect of `camtruth effects`, not its model.
"""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from PIL import Image
from scipy import ndimage

from docs.examples.another_body import HEIGHT, MIDDLE, WIDTH, Camera, Numbers, X, Y


def seen_at(light: Numbers, y: Numbers, x: Numbers) -> Numbers:
    """A plane of light, looked up elsewhere."""
    return np.asarray(ndimage.map_coordinates(light, [y, x], order=1, mode="nearest"))


# Light of one exposure, in electrons of each colour: (camera, light, frame, exposure) -> light


def ambient_light(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    return light + 200_000 * c.k * exposure_s * np.array([1, 0.8, 0.5])


def veiling_glare(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    part = 0.03 * c.k
    return (1 - part) * light + part * light.mean(axis=(0, 1))


def lamp_flicker(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    return light * (1 + 0.01 * c.k * np.sin(2 * np.pi * 0.37 * frame + 1.1))


def lamp_drift(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    return light * (1 + 0.02 * c.k * (frame / c.frames - 0.5))


def dust_shadow(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    draw = np.random.default_rng(5)
    for y, x, r in draw.uniform((0, 0, 3), (HEIGHT, WIDTH, 8), (12, 3)):
        away = ((Y - y) ** 2 + (X - x) ** 2) / r**2
        light = light * (1 - 0.03 * c.k * np.exp(-(away**2)))[..., None]
    return light


def large_scale_prnu(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    return light * (1 + 0.01 * c.k * c.waves)[..., None]


def lateral_chromatic_aberration(
    c: Camera, light: Numbers, frame: int, exposure_s: float
) -> Numbers:
    planes = [
        seen_at(
            light[..., colour], MIDDLE[0] + (Y - MIDDLE[0]) / m, MIDDLE[1] + (X - MIDDLE[1]) / m
        )
        for colour, m in enumerate((1 + 0.004 * c.k, 1.0, 1 - 0.004 * c.k))
    ]
    return np.stack(planes, axis=-1)


def lens_distortion(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    y, x = Y - MIDDLE[0], X - MIDDLE[1]
    m = 1 + 0.02 * c.k * (y**2 + x**2) / (MIDDLE[0] ** 2 + MIDDLE[1] ** 2)
    planes = [seen_at(light[..., k], MIDDLE[0] + m * y, MIDDLE[1] + m * x) for k in range(3)]
    return np.stack(planes, axis=-1)


def vibration(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    return np.asarray(ndimage.uniform_filter1d(light, 1 + 2 * round(2 * c.k), axis=1))


def defocus_error(c: Camera, light: Numbers, frame: int, exposure_s: float) -> Numbers:
    wide = 2 * round(2 * c.k) + 3
    at = (np.arange(16 * wide) + 0.5) / 16 - wide / 2
    inside = at[:, None] ** 2 + at**2 < (2 * c.k) ** 2
    disc = inside.reshape(wide, 16, wide, 16).mean(axis=(1, 3))[..., None]
    return np.asarray(ndimage.convolve(light, disc / disc.sum(), mode="nearest"))


# Mean electrons of each photosite, before they are counted: (camera, mean, frame, exposure) -> mean


def crosstalk(c: Camera, mean: Numbers, frame: int, exposure_s: float) -> Numbers:
    cross = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]]) / 4
    part = 0.06 * c.k
    return (1 - part) * mean + part * ndimage.convolve(mean, cross, mode="nearest")


def hot_pixels(c: Camera, mean: Numbers, frame: int, exposure_s: float) -> Numbers:
    excess = -300_000 * c.k * exposure_s * np.log(c.other_chance + 1e-9)
    return mean + np.where(c.chance < 0.003, excess, 0)


def smear(c: Camera, mean: Numbers, frame: int, exposure_s: float) -> Numbers:
    return mean + 0.0004 * c.k * mean.sum(axis=0)


# Electrons that were counted: (camera, electrons, frame) -> electrons


def brighter_fatter(c: Camera, e: Numbers, frame: int) -> Numbers:
    moved = np.zeros_like(e)
    for axis in (0, 1):
        step = np.diff(e, axis=axis)
        middle = (np.delete(e, 0, axis) + np.delete(e, -1, axis)) / 2
        flow = 1.5e-6 * c.k * step * middle
        before = [(0, 0), (0, 0)]
        before[axis] = (0, 1)
        moved += np.pad(flow, before) - np.pad(flow, [pair[::-1] for pair in before])
    return e + moved


def nonlinearity(c: Camera, e: Numbers, frame: int) -> Numbers:
    return e * (1 - 0.02 * c.k * e / 4000)


def image_lag(c: Camera, e: Numbers, frame: int) -> Numbers:
    part = 0.02 * c.k
    before = c.memory.get("lag", part * e.mean() * np.ones_like(e) if frame else part * e)
    c.memory["lag"] = part * e
    return (1 - part) * e + before


def blooming(c: Camera, e: Numbers, frame: int) -> Numbers:
    full = 4600 / c.k
    for _ in range(20):
        over = np.maximum(e - full, 0)
        e = np.minimum(e, full) + (np.roll(over, 1, 0) + np.roll(over, -1, 0)) / 2
    return np.minimum(e, full)


def random_telegraph_noise(c: Camera, e: Numbers, frame: int) -> Numbers:
    up = c.memory.get("up", c.other_chance < 0.5)
    c.memory["up"] = up ^ (c.draw.uniform(size=e.shape) < 0.2)
    return e + np.where((c.chance < 0.02 * c.k) & up, 60, 0)


def charge_transfer_inefficiency(c: Camera, e: Numbers, frame: int) -> Numbers:
    lost = e * np.clip(1e-4 * c.k * X, 0, 0.9)
    after = e - lost
    after[:, 1:] += lost[:, :-1]
    return after


# Electrons with the noise of the read-out: (camera, electrons, frame) -> electrons


def row_noise(c: Camera, e: Numbers, frame: int) -> Numbers:
    return e + c.draw.normal(0, 6 * c.k, (HEIGHT, 1))


def column_fpn(c: Camera, e: Numbers, frame: int) -> Numbers:
    return e + 5 * c.k * c.columns


def interference(c: Camera, e: Numbers, frame: int) -> Numbers:
    wave = 2 * np.pi * (0.11 * (X + WIDTH * Y) + 0.13 * frame)
    return e + 8 * c.k * np.sin(wave)


def flicker_noise(c: Camera, e: Numbers, frame: int) -> Numbers:
    waves = np.fft.rfft(c.draw.normal(size=e.size))
    noise = np.fft.irfft(waves / np.sqrt(np.arange(1, len(waves) + 1)), e.size)
    return e + 8 * c.k * ((noise - noise.mean()) / noise.std()).reshape(e.shape)


def black_level_drift(c: Camera, e: Numbers, frame: int) -> Numbers:
    c.memory["black"] = c.memory.get("black", 0.0) + c.draw.normal(0, 3 * c.k)
    return e + c.memory["black"]


# Samples of the mosaic in DN, behind the converter's gain: (camera, dn, frame) -> dn


def adc_dnl(c: Camera, dn: Numbers, frame: int) -> Numbers:
    edges = np.arange(c.top) + 0.5 + c.k * 0.4 * np.random.default_rng(8).uniform(-1, 1, c.top)
    return np.searchsorted(np.sort(edges), dn).astype(float)


def bit_truncation(c: Camera, dn: Numbers, frame: int) -> Numbers:
    return np.floor(np.round(dn) / 4) * 4


def defect_correction(c: Camera, dn: Numbers, frame: int) -> Numbers:
    steps = (-c.period, 0, c.period)
    near = [np.roll(dn, (y, x), (0, 1)) for y in steps for x in steps if y or x]
    middle = np.median(near, axis=0)
    return np.where(np.abs(dn - middle) > 3.5 * c.finer / c.k, middle, dn)


# The picture in DN, three colours in every pixel: (camera, picture, frame) -> picture


def gamma(c: Camera, rgb: Numbers, frame: int) -> Numbers:
    return c.top * (np.clip(rgb, 0, c.top) / c.top) ** (1 / (1 + 0.15 * c.k))


def color_matrix(c: Camera, rgb: Numbers, frame: int) -> Numbers:
    s = 0.15 * c.k
    mixed = np.array([[1 + s, -0.7 * s, -0.3 * s], [-0.4 * s, 1 + s, -0.6 * s],
                      [-0.1 * s, -0.9 * s, 1 + s]])  # fmt: skip
    return (rgb - c.black_dn) @ mixed.T + c.black_dn


def sharpening(c: Camera, rgb: Numbers, frame: int) -> Numbers:
    return rgb + 0.3 * c.k * (rgb - ndimage.gaussian_filter(rgb, (1, 1, 0)))


def spatial_denoise(c: Camera, rgb: Numbers, frame: int) -> Numbers:
    return np.asarray(ndimage.gaussian_filter(rgb, (0.4 * c.k, 0.4 * c.k, 0)))


def temporal_filter(c: Camera, rgb: Numbers, frame: int) -> Numbers:
    before = c.memory.get("shown", rgb)
    c.memory["shown"] = before + (1 - 0.2 * c.k) * (rgb - before)
    return np.asarray(c.memory["shown"])


# Codes as they leave the camera: (camera, codes, frame) -> codes


def chroma_subsampling(c: Camera, codes: Numbers, frame: int) -> Numbers:
    luma = codes @ [0.299, 0.587, 0.114]
    blue, red = 0.564 * (codes[..., 2] - luma), 0.713 * (codes[..., 0] - luma)
    blue, red = (np.round(np.repeat((p[:, ::2] + p[:, 1::2]) / 2, 2, axis=1)) for p in (blue, red))
    luma = np.round(luma)
    rgb = [luma + 1.403 * red, luma - 0.344 * blue - 0.714 * red, luma + 1.773 * blue]
    return np.stack(rgb, axis=-1)


def jpeg(c: Camera, codes: Numbers, frame: int) -> Numbers:
    file = io.BytesIO()
    picture = Image.fromarray(codes.astype(np.uint8))
    picture.save(file, "JPEG", quality=int(95 - 5 * c.k), subsampling=0)
    return np.asarray(Image.open(file), dtype=float)


def dropped_frames(c: Camera, codes: Numbers, frame: int) -> Numbers:
    if "sent" in c.memory and c.draw.uniform() < 0.1 * c.k:
        return np.asarray(c.memory["sent"])
    c.memory["sent"] = codes
    return codes


Fault = Callable[..., Numbers]


def named(*faults: Fault) -> dict[str, Fault]:
    return {fault.__name__: fault for fault in faults}


OF_LIGHT = named(
    ambient_light, veiling_glare, lamp_flicker, lamp_drift, dust_shadow, large_scale_prnu,
    lateral_chromatic_aberration, lens_distortion, vibration, defocus_error,
)  # fmt: skip
OF_MEANS = named(crosstalk, hot_pixels, smear)
OF_CHARGE = named(
    brighter_fatter, nonlinearity, image_lag, blooming, random_telegraph_noise,
    charge_transfer_inefficiency,
)  # fmt: skip
OF_READING = named(row_noise, column_fpn, interference, flicker_noise, black_level_drift)
OF_SAMPLES = named(adc_dnl, bit_truncation, defect_correction)
OF_PICTURES = named(gamma, color_matrix, sharpening, spatial_denoise, temporal_filter)
OF_CODES = named(chroma_subsampling, jpeg, dropped_frames)
OF_FILLING = ("demosaic_other",)
FAULTS = (
    *OF_LIGHT, *OF_MEANS, *OF_CHARGE, *OF_READING, *OF_SAMPLES, *OF_FILLING, *OF_PICTURES,
    *OF_CODES,
)  # fmt: skip
OF_RAW = (
    *OF_LIGHT, *OF_MEANS, *OF_CHARGE, *OF_READING, *OF_SAMPLES, dropped_frames.__name__,
)  # fmt: skip
UNSEEN = {
    veiling_glare, lateral_chromatic_aberration, lens_distortion, vibration, defocus_error,
    ambient_light, crosstalk, smear, blooming,
}  # fmt: skip
"""By an even picture without colours."""
OF_FLATS = tuple(name for name in OF_RAW if name not in {one.__name__ for one in UNSEEN})
