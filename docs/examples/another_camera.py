"""A camera by somebody else: plain NumPy, one fault at a time, and none of the simulator's code.

    python docs/examples/another_camera.py OUT --fault hot_pixels --strength 1 --seed 41
    camtruth diagnose OUT

Only the light is rendered by camtruth; sensor, faults and files are written here, by the formulas
that come to mind first. The faults have the names of `camtruth effects`, not its models: what the
diagnosis says of them is said of a camera that it cannot know. `--fault none` has none.
`make another-camera` asks it of each, and writes docs/another-camera.md.
"""

from __future__ import annotations

import argparse
import io
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

import camtruth

Numbers = NDArray[Any]

WIDTH, HEIGHT, FRAMES = 160, 120, 40
INTERVAL_S = 0.0667
DARK_S, LIT_S = (0.0005, 0.001, 0.002), 0.002
LEVELS = (0.25, 0.5, 1.0)
TOP = 255


@dataclass(kw_only=True)
class Camera:
    """One body, and what it remembers from frame to frame of a shot.

    Figures are drawn about those of a consumer camera of 2005. `k` is how strong its fault is.
    """

    k: float
    draw: np.random.Generator
    cfa: str = "RGGB"
    gain_dn_per_e: Numbers = field(init=False)
    black_dn: float = field(init=False)
    read_e: float = field(init=False)
    offset_e: Numbers = field(init=False)
    response: Numbers = field(init=False)
    dark_e_per_s: float = field(init=False)
    columns: Numbers = field(init=False)
    waves: Numbers = field(init=False)
    chance: Numbers = field(init=False)
    other_chance: Numbers = field(init=False)
    memory: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        draw, shape = self.draw, (HEIGHT, WIDTH)
        by_colour = np.array([0.055, 0.050, 0.060]) * draw.uniform(0.85, 1.15)
        self.gain_dn_per_e = np.empty(shape)
        for (y, x), colour in zip(SITES, self.cfa, strict=True):
            self.gain_dn_per_e[y::2, x::2] = by_colour["RGB".index(colour)]
        self.black_dn, self.read_e = draw.uniform(2.5, 5), draw.uniform(8, 18)
        self.offset_e = draw.normal(0, draw.uniform(3, 8), shape)
        self.response = 1 + draw.normal(0, draw.uniform(0.006, 0.012), shape)
        self.dark_e_per_s = draw.uniform(800, 4000)
        self.columns = draw.normal(0, 1, WIDTH)
        self.waves = ndimage.gaussian_filter(draw.normal(size=shape), 12, mode="wrap")
        self.waves /= self.waves.std()
        self.chance, self.other_chance = draw.uniform(size=(2, *shape))


SITES = ((0, 0), (0, 1), (1, 0), (1, 1))
Y, X = np.mgrid[:HEIGHT, :WIDTH].astype(float)
MIDDLE = ((HEIGHT - 1) / 2, (WIDTH - 1) / 2)


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
    return light * (1 + 0.02 * c.k * (frame / FRAMES - 0.5))


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
    edges = np.arange(TOP) + 0.5 + c.k * 0.4 * np.random.default_rng(8).uniform(-1, 1, TOP)
    return np.searchsorted(np.sort(edges), dn).astype(float)


def bit_truncation(c: Camera, dn: Numbers, frame: int) -> Numbers:
    return np.floor(np.round(dn) / 4) * 4


def defect_correction(c: Camera, dn: Numbers, frame: int) -> Numbers:
    near = [np.roll(dn, (2 * y, 2 * x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1) if y or x]
    middle = np.median(near, axis=0)
    return np.where(np.abs(dn - middle) > 3.5 / c.k, middle, dn)


# The picture in DN, three colours in every pixel: (camera, picture, frame) -> picture


def gamma(c: Camera, rgb: Numbers, frame: int) -> Numbers:
    return TOP * (np.clip(rgb, 0, TOP) / TOP) ** (1 / (1 + 0.15 * c.k))


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


def photograph(c: Camera, light: Numbers, exposure_s: float, fault: str) -> Numbers:
    """The frames of one shot, (FRAMES, HEIGHT, WIDTH, 3).

    Args:
        c: the camera.
        light: mean photo-electrons of the exposure by colour, (HEIGHT, WIDTH, 3).
        exposure_s: its length.
        fault: name of what is wrong with the camera.
    """

    def unharmed(camera: Camera, value: Numbers, *about: float) -> Numbers:
        return value

    c.memory.clear()
    frames = []
    for frame in range(FRAMES):
        rgb = OF_LIGHT.get(fault, unharmed)(c, light, frame, exposure_s)
        mean = mosaic(rgb, c.cfa) * c.response
        mean = OF_MEANS.get(fault, unharmed)(
            c, mean + c.dark_e_per_s * exposure_s, frame, exposure_s
        )
        electrons = c.draw.poisson(mean).astype(float)
        electrons = OF_CHARGE.get(fault, unharmed)(c, electrons, frame)
        read = electrons + c.offset_e + c.draw.normal(0, c.read_e, mean.shape)
        read = OF_READING.get(fault, unharmed)(c, read, frame)
        dn = OF_SAMPLES.get(fault, unharmed)(c, read * c.gain_dn_per_e + c.black_dn, frame)
        codes = np.clip(np.round(dn), 0, TOP)
        filled = (edge_aware if fault in OF_FILLING else bilinear)(codes, c.cfa)
        picture = OF_PICTURES.get(fault, unharmed)(c, filled, frame)
        sent = OF_CODES.get(fault, unharmed)(c, np.clip(np.round(picture), 0, TOP), frame)
        frames.append(np.clip(np.round(sent), 0, TOP).astype(np.uint8))
    return np.stack(frames)


def mosaic(rgb: Numbers, cfa: str) -> Numbers:
    """What falls on the photosites behind their filters."""
    behind = np.empty(rgb.shape[:2])
    for (y, x), colour in zip(SITES, cfa, strict=True):
        behind[y::2, x::2] = rgb[y::2, x::2, "RGB".index(colour)]
    return behind


def bilinear(codes: Numbers, cfa: str) -> Numbers:
    """Colours between, as means of neighbours, in fractions."""
    square = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 4
    cross = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 4
    planes = []
    for colour, kernel in (("R", square), ("G", cross), ("B", square)):
        here = np.zeros_like(codes)
        for (y, x), own in zip(SITES, cfa, strict=True):
            here[y::2, x::2] = own == colour
        known = ndimage.convolve(here, kernel, mode="mirror")
        planes.append(ndimage.convolve(codes * here, kernel, mode="mirror") / known)
    return np.stack(planes, axis=-1)


def edge_aware(codes: Numbers, cfa: str) -> Numbers:
    """The same by OpenCV's variable number of gradients."""
    way = getattr(cv2, f"COLOR_Bayer{cfa}2RGB_VNG")
    return np.asarray(cv2.cvtColor(codes.astype(np.uint8), way), dtype=float)


def main() -> None:
    words = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    words.add_argument("out", type=Path, help="capture folder to write; must not exist")
    words.add_argument("--fault", choices=("none", *FAULTS), default="none")
    words.add_argument("--strength", type=float, default=1.0, help="1 is a usual one")
    words.add_argument("--seed", type=int, default=41)
    words.add_argument("--cfa", choices=("RGGB", "GRBG", "GBRG", "BGGR"), default="RGGB")
    words.add_argument(
        "--paths", type=int, help="light paths a pixel; the light is then named and not given"
    )
    given = words.parse_args()
    given.out.mkdir(parents=True)
    lamps = ("fluorescent", "incandescent")
    scene = camtruth.load_scene("chart").with_size(WIDTH, HEIGHT)
    more = {"samples": given.paths, "seed": given.seed} if given.paths else {}
    images = camtruth.render(scene, lamps, **more)
    body = [given.seed, *given.fault.encode()]
    camera = Camera(k=given.strength, draw=np.random.default_rng(body), cfa=given.cfa)
    text = ['format = "camtruth-capture/1"', 'camera = "another"', 'pixels = "rgb8"', "bits = 8",
            f'cfa = "{given.cfa}"']  # fmt: skip
    text += ['scene = "chart"'] * bool(given.paths)
    shots = [(f"dark-{1e3 * t:g}ms", "none", 1.0, t) for t in DARK_S]
    shots += [(f"{lamp}-{100 * level:g}", lamp, level, LIT_S) for lamp in lamps for level in LEVELS]
    for label, lamp, level, exposure_s in shots:
        light = np.zeros((HEIGHT, WIDTH, 3))
        if lamp != "none":
            light = images[lamp].rate_e_per_s.astype(float) * level * exposure_s
        np.save(given.out / f"{label}.npy", photograph(camera, light, exposure_s, given.fault))
        text += ["", "[[shot]]", f'label = "{label}"', f'light = "{lamp}"', f"level = {level}",
                 f"exposure_s = {exposure_s}", f"interval_s = {INTERVAL_S}",
                 f'frames = "{label}.npy"']  # fmt: skip
        if lamp != "none" and not given.paths:
            text.append(f'rate = "rate-{lamp}.exr"')
    for lamp, image in images.items():
        if not given.paths:
            camtruth.write_rate(given.out / f"rate-{lamp}.exr", image)
    for panel in images[lamps[0]].header.panels:
        place = [f"{key} = {int(getattr(panel, key))}" for key in "xywh"]
        text += ["", "[[panel]]", f'name = "{panel.name}"', *place]
    (given.out / "capture.toml").write_text("\n".join(text) + "\n")


if __name__ == "__main__":
    main()
