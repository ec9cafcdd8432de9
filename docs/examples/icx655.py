"""Fit the camera `icx655` to real frames: `python docs/examples/icx655.py FOLDER`.

FOLDER holds `dark_frames/` and `disks/`: 8-bit Bayer frames (GBRG) of a Sony ICX655AQ in a Point
Grey FL3-GE-50S5C at 48 degrees Celsius, one frame for each of seven narrow bands and seven
exposures. They are `demo_data/captured_images` of github.com/bllanos/chromatic-aberration, cropped.
"""

from __future__ import annotations

import math
import sys
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import tifffile
from numpy.typing import NDArray
from scipy import ndimage, stats

EXPOSURES_MS = (25, 50, 100, 250, 500, 2000, 3916)
BANDS_NM = range(400, 701, 50)
SITES = {"G": (0, 0), "B": (0, 1), "R": (1, 0), "G2": (1, 1)}
WARMTH = 2 ** ((48 - 29) / 8)
"""Growth of dark charge from 29 degrees Celsius, where parameters are stated, to the sensor's 48:
it doubles every 8 degrees."""
TILE, FLATTEST = 8, 0.01
"""Tiles of 8 x 8 sites of one colour; taken where their slopes are below 1 % of their mean."""

Image = NDArray[np.float64]


def frames(folder: Path, pattern: str) -> list[Image]:
    return [tifffile.imread(path).astype(float) for path in sorted(folder.glob(pattern))]


def tiles(lattice: Image) -> Image:
    h, w = (n // TILE * TILE for n in lattice.shape)
    cut = lattice[:h, :w].reshape(h // TILE, TILE, w // TILE, TILE)
    return cut.swapaxes(1, 2).reshape(-1, TILE * TILE)


def photon_transfer(folder: Path, black: float) -> tuple[float, float, float]:
    """Gain in DN/e-, its standard error, and the noise at no light in DN, from exposure pairs.

    Two exposures a and b of the same scene, with r = mean b / mean a in a tile: b - r a is free of
    the scene and of PRNU, and its variance is k (b + r^2 a) + (1 + r^2) (s^2 + 1/12).
    """
    y, x = np.mgrid[-1 : 1 : TILE * 1j, -1 : 1 : TILE * 1j]
    parabola = np.stack([x**i * y**j for i in range(3) for j in range(3 - i)], -1)
    smooth = np.linalg.qr(parabola.reshape(TILE * TILE, -1))[0]
    freedom = TILE * TILE - smooth.shape[1]
    rows = []
    for band in BANDS_NM:
        stack = [frames(folder, f"disks/*_{band}nm_{t}ms_*")[0] for t in EXPOSURES_MS]
        for a, b in pairwise(stack):
            for i, j in SITES.values():
                first, second = tiles(a[i::2, j::2]), tiles(b[i::2, j::2])
                slopes = np.abs((second @ smooth)[:, 1:]).max(1) / TILE
                good = (first.min(1) >= 2) & (second.max(1) <= 250)
                good &= slopes < FLATTEST * second.mean(1)
                first, second = first[good] - black, second[good] - black
                ratio = second.mean(1) / first.mean(1)
                left = second - ratio[:, None] * first
                left -= (left @ smooth) @ smooth.T
                light = second.mean(1) + ratio**2 * first.mean(1)
                rows.append(np.stack([light, 1 + ratio**2, (left**2).sum(1) / freedom], 1))
    light, twice, variance = np.concatenate(rows).T
    design = np.stack([light, twice], 1)
    weight = np.ones(len(light))
    for _ in range(20):
        root = np.sqrt(weight)[:, None]
        figures = np.linalg.lstsq(design * root, variance * root[:, 0])[0]
        weight = 1 / np.maximum(design @ figures, 0.05) ** 2
    covariance = np.linalg.inv((design.T * weight) @ design) * 2 / freedom
    gain, rest = figures
    print(f"photon transfer: {len(light)} tiles, {1 / gain:.2f} e-/DN")
    return float(gain), float(np.sqrt(covariance[0, 0])), math.sqrt(rest - 1 / 12)


def share_above_zero(folder: Path, sitting: str, exposure_ms: int) -> float:
    """How often noise alone lifts a dark pixel to 1 DN: in one of two frames and not in both."""
    a, b = frames(folder, f"dark_frames/{sitting}_dark_{exposure_ms}ms_*")
    return float(((a > 0) != (b > 0)).mean() / 2)


def hot_pixels(folder: Path, sitting: str, black: float, gain: float) -> tuple[float, float]:
    """Share of hot pixels and their mean rate in e-/s at 29 degrees Celsius.

    Exponential rates: the mean above a threshold, less the threshold, is the mean of all.
    """
    seconds = EXPOSURES_MS[-1] / 1000
    a, b = frames(folder, f"dark_frames/{sitting}_dark_{EXPOSURES_MS[-1]}ms_*")
    least = 2.5
    hot = np.minimum(a, b) > least
    charge = ((a + b)[hot] / 2 - least).mean() / gain
    share = hot.mean() * math.exp((least - black) / gain / charge)
    return float(share), float(charge / seconds / WARMTH)


def common_pattern(folder: Path) -> tuple[float, float]:
    """Relative covariance of fine structure between bands, and its standard error.

    PRNU is the same in every band; the fringes of a narrow band, 2 to 4 % here, are not.
    """
    figures = []
    for i, j in SITES.values():
        fine = {}
        for band in BANDS_NM:
            for t in EXPOSURES_MS:
                lattice = frames(folder, f"disks/*_{band}nm_{t}ms_*")[0][i::2, j::2]
                if np.percentile(lattice, 99) < 250 and lattice.mean() > 25:
                    local = ndimage.uniform_filter(lattice, 5)
                    steep = np.hypot(*np.gradient(ndimage.uniform_filter(lattice, 7)))
                    good = (ndimage.minimum_filter(lattice, 9) > 10) & (steep < 0.015 * local)
                    fine[band] = lattice / np.maximum(local, 1) - 1, good
        for (a, at), (b, bt) in combinations(fine.values(), 2):
            figures.append((a * b)[at & bt].mean())
    # bands, not pixels, are the independent samples: about one in two pairs of neighbours
    return float(np.median(figures)), float(np.std(figures) / math.sqrt(len(figures) / 2))


def main() -> None:
    folder = Path(sys.argv[1])
    black = 0.0
    for _ in range(6):  # black and noise each need the other
        gain, error, noise = photon_transfer(folder, black)
        lifted = [share_above_zero(folder, sitting, 25) for sitting in ("d1", "d2")]
        blacks = [0.5 - noise * stats.norm.isf(share) for share in lifted]
        black = float(np.mean(blacks))
    print(
        f"gain {gain:.5f} +- {error:.5f} DN/e-, {1 / gain:.2f} e-/DN, 255 DN at {255 / gain:.0f} e-"
    )
    print(f"read noise {noise:.3f} DN, {noise / gain:.1f} e-")
    print(f"black level {black:.2f} DN; by sitting {blacks[0]:.2f} and {blacks[1]:.2f}")
    for sitting, first in zip(("d1", "d2"), lifted, strict=True):
        last = share_above_zero(folder, sitting, EXPOSURES_MS[-1])
        own = blacks[0] if sitting == "d1" else blacks[1]
        grown = ((0.5 - own) / stats.norm.isf(last)) ** 2 - noise**2
        current = grown / gain**2 / (EXPOSURES_MS[-1] / 1000)
        print(f"{sitting}: {first:.5f} above zero at 25 ms, {last:.5f} at 3916 ms:")
        print(f"    dark current {current:.2f} e-/s at 48 degC, {current / WARMTH:.2f} at 29 degC")
        share, rate = hot_pixels(folder, sitting, own, gain)
        print(f"    hot pixels: {share:.2e} of all, {rate:.1f} e-/s at 29 degC")
    common, spread = common_pattern(folder)
    least = math.sqrt(max(common + 2 * spread, 0))
    print(f"pattern common to the bands: {common:.1e} +- {spread:.1e}: PRNU below {least:.2%}")


if __name__ == "__main__":
    main()
