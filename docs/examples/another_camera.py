"""A camera by somebody else: plain NumPy, one fault at a time, and none of the simulator's code.

    python -m docs.examples.another_camera OUT --fault hot_pixels --strength 1 --seed 41
    camtruth diagnose OUT

Only the light is rendered by camtruth, and none of a grey camera's; sensor, faults and files are
written here. The faults have the names of `camtruth effects`, not its models: what the diagnosis
says of them is said of a camera that it cannot know. `--fault none` has none.
`make another-camera` asks it of each, and writes docs/another-camera.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy import ndimage

import camtruth
from docs.examples.another_body import (
    GREY,
    HEIGHT,
    MIDDLE,
    SITES,
    WIDTH,
    Camera,
    Numbers,
    X,
    Y,
    mosaic,
)
from docs.examples.another_faults import (
    FAULTS,
    OF_CHARGE,
    OF_CODES,
    OF_FILLING,
    OF_FLATS,
    OF_LIGHT,
    OF_MEANS,
    OF_PICTURES,
    OF_RAW,
    OF_READING,
    OF_SAMPLES,
)

INTERVAL_S = 0.0667
DARK_S, LIT_S = (0.0005, 0.001, 0.002), 0.002
LAMPS, LEVELS = ("fluorescent", "incandescent"), (0.25, 0.5, 1.0)
FLAT, FLAT_LEVELS, BRIGHTEST_E = "led", (0.05, 0.2, 0.5, 1.0), 3500.0

KINDS = {"rgb8": FAULTS, "bayer16": OF_RAW, "mono16": OF_FLATS}
"""Of pixels, with the faults that each can have. Raw ones have 12 bits, grey ones see flats."""


def photograph(c: Camera, light: Numbers, exposure_s: float, fault: str, pixels: str) -> Numbers:
    """The frames of one shot, (frames, HEIGHT, WIDTH), of colours (frames, HEIGHT, WIDTH, 3).

    Args:
        c: the camera.
        light: mean photo-electrons of the exposure by colour, (HEIGHT, WIDTH, 3).
        exposure_s: its length.
        fault: name of what is wrong with the camera.
        pixels: one of `KINDS`.
    """

    def unharmed(camera: Camera, value: Numbers, *about: float) -> Numbers:
        return value

    c.memory.clear()
    frames = []
    for frame in range(c.frames):
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
        codes = np.clip(np.round(dn), 0, c.top)
        if pixels == "rgb8":
            filled = (edge_aware if fault in OF_FILLING else bilinear)(codes, c.cfa)
            codes = np.clip(np.round(OF_PICTURES.get(fault, unharmed)(c, filled, frame)), 0, c.top)
        codes = OF_CODES.get(fault, unharmed)(c, codes, frame)
        frames.append(np.clip(np.round(codes), 0, c.top))
    return np.stack(frames).astype(np.uint8 if c.bits == 8 else np.uint16)


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
    """Colours between, by OpenCV's variable number of gradients, (H, W, 3); codes of 8 bits."""
    way = getattr(cv2, f"COLOR_Bayer{cfa}2RGB_VNG")
    return np.asarray(cv2.cvtColor(codes.astype(np.uint8), way), dtype=float)


def flat() -> Numbers:
    """An even picture, as even as a lens makes one: a sixth darker in the corners."""
    y, x = Y - MIDDLE[0], X - MIDDLE[1]
    falls = 0.15 * (y**2 + x**2) / (MIDDLE[0] ** 2 + MIDDLE[1] ** 2)
    return np.asarray(1 - falls + 0.02 * x / MIDDLE[1])


Shot = tuple[str, str, float, float, Numbers]
"""Label, light, level, exposure, and mean photo-electrons by colour."""


def darks() -> Iterator[Shot]:
    """Shots with the lens capped."""
    for exposure_s in DARK_S:
        nothing = np.zeros((HEIGHT, WIDTH, 3))
        yield f"dark-{1e3 * exposure_s:g}ms", "none", 1.0, exposure_s, nothing


def of_chart(images: Mapping[str, camtruth.RateImage]) -> Iterator[Shot]:
    """Shots of the chart under each lamp."""
    for lamp in LAMPS:
        for level in LEVELS:
            light = images[lamp].rate_e_per_s.astype(float) * level * LIT_S
            yield f"{lamp}-{100 * level:g}", lamp, level, LIT_S, light


def of_flats() -> Iterator[Shot]:
    """Shots of nothing, evenly lit."""
    for level in FLAT_LEVELS:
        light = np.repeat(BRIGHTEST_E * level * flat()[..., None], 3, axis=2)
        yield f"{FLAT}-{100 * level:g}", FLAT, level, LIT_S, light


def main() -> None:
    words = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    words.add_argument("out", type=Path, help="capture folder to write; must not exist")
    words.add_argument("--fault", choices=("none", *FAULTS), default="none")
    words.add_argument("--strength", type=float, default=1.0, help="1 is a usual one")
    words.add_argument("--seed", type=int, default=41)
    words.add_argument("--pixels", choices=tuple(KINDS), default="rgb8")
    words.add_argument("--cfa", choices=("RGGB", "GRBG", "GBRG", "BGGR"), default="RGGB")
    words.add_argument(
        "--paths", type=int, help="light paths a pixel; the light is then named and not given"
    )
    given = words.parse_args()
    if given.fault not in ("none", *KINDS[given.pixels]):
        words.error(f"{given.fault} does not show in {given.pixels}")
    given.out.mkdir(parents=True)
    grey = given.pixels == "mono16"
    camera = Camera(
        k=given.strength,
        draw=np.random.default_rng([given.seed, *given.fault.encode()]),
        cfa=GREY if grey else given.cfa,
        bits=8 if given.pixels == "rgb8" else 12,
    )
    images = {} if grey else rendered(given.paths, given.seed)
    text = ['format = "camtruth-capture/1"', 'camera = "another"', f'pixels = "{given.pixels}"',
            f"bits = {camera.bits}"]  # fmt: skip
    text += [f'cfa = "{camera.cfa}"'] * (not grey)
    stated = bool(images) and not given.paths
    text += ['scene = "chart"'] * bool(images and not stated)
    for label, lamp, level, exposure_s, light in (
        *darks(),
        *(of_flats() if grey else of_chart(images)),
    ):
        frames = photograph(camera, light, exposure_s, given.fault, given.pixels)
        np.save(given.out / f"{label}.npy", frames)
        text += ["", "[[shot]]", f'label = "{label}"', f'light = "{lamp}"', f"level = {level}",
                 f"exposure_s = {exposure_s}", f"interval_s = {INTERVAL_S}",
                 f'frames = "{label}.npy"']  # fmt: skip
        if lamp != "none" and stated:
            text.append(f'rate = "rate-{lamp}.exr"')
    for lamp, image in images.items():
        if stated:
            camtruth.write_rate(given.out / f"rate-{lamp}.exr", image)
    for panel in images[LAMPS[0]].header.panels if images else ():
        place = [f"{key} = {int(getattr(panel, key))}" for key in "xywh"]
        text += ["", "[[panel]]", f'name = "{panel.name}"', *place]
    (given.out / "capture.toml").write_text("\n".join(text) + "\n")


def rendered(paths: int | None, seed: int) -> dict[str, Any]:
    """Rate images of the chart by lamp."""
    scene = camtruth.load_scene("chart").with_size(WIDTH, HEIGHT)
    more: dict[str, Any] = {"samples": paths, "seed": seed} if paths else {}
    return dict(camtruth.render(scene, LAMPS, **more))


if __name__ == "__main__":
    main()
