"""A wave over the frames: its period along the read-out, its turn from row to row, frame to frame.

Where a wave has f_x cycles a pixel along the rows and f_y cycles a row down them, it is one wave of
the read-out whose period is P = 1 / f_x and whose lines are W + B pixels long,

    (W + B) / P = f_y  (modulo 1).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from analysis.gap.look.lattices import Lattice
from analysis.gap.look.shots import HINT_FRAMES
from analysis.gap.ready.hints import Hints
from sensor.frames import Frames

Floats = NDArray[np.float64]
Images = NDArray[np.float32]
Phasors = NDArray[np.complex128]

FINER = 9
"""Places that are tried between two points of a spectrum, along each axis; twice over."""

SLIP = 0.05
"""Cycles by which a wave must turn from row to row for lines to be longer than they look."""

KEEPS_TIME = 0.5
"""Length of the mean step of the phase from frame to frame, as a phasor, of a source that does."""

LAGS = (6, 2)
"""Frames after which it is looked for how much of a phase is left, most first."""

LEAST_AGREEMENT = 0.3
"""Of phasors that far apart, so that they tell a walk."""

LEAST_WALK = 0.01
"""Cycles of a walk that is told from none: it costs a hundredth of the agreement in five frames."""

NO_WAVE = 1e-12
"""Of phasors that are none: a shot of one frame has no steps."""


def wave(stacks: Sequence[Frames], lattices: tuple[Lattice, ...]) -> Hints:
    """Period, blanking, drift, jitter and walk of the strongest wave in the noise.

    Args:
        stacks: frames of the shots.
        lattices: where their measured samples are.
    """
    noise = [_mosaic(stack, lattices) for stack in stacks]
    period, of_read_out = _along(noise)
    down, across, power = _between_rows_and_columns(noise)
    width, blanking = noise[0].shape[2], 0.0
    slip = (down - across * width + 0.5) % 1.0 - 0.5
    if power > of_read_out and abs(slip) > SLIP:
        period, blanking = 1.0 / across, (slip % 1.0) / across
        phasors = _phasors(noise, down, across)
    else:
        phasors = _phasors(noise, width / period, 1.0 / period)
    steps = _steps(phasors, 1)
    keeps = _agreement(steps) > KEEPS_TIME
    return {
        "period_px": period,
        "blanking_px": blanking,
        "drift_cycles_per_frame": float(np.angle(steps.sum()) / (2 * np.pi)) if keeps else 0.0,
        "jitter_cycles": 0.0 if keeps else 1.0,
        "walk_cycles": _walk(phasors) if keeps else 0.0,
    }


def _along(noise: Sequence[Images]) -> tuple[float, float]:
    """Period along the read-out of the strongest wave if lines are as long as they look, in pixels,
    and its power.

    The spectrum is that of a whole frame in the order it is read, so that waves along the rows,
    waves across them and all between are one peak each.
    """
    pixels = noise[0][0].size
    series = (one.reshape(-1, pixels) for one in noise)
    power = np.sum([np.square(np.abs(fft.rfft(one))).mean(axis=0) for one in series], axis=0)
    # drifts of whole frames are not waves, and nothing is faster than two pixels
    low = 8
    peak = low + int(np.argmax(power[low:]))
    return max(float(pixels / _between(power, peak)), 2.0), float(power[peak])


def _between_rows_and_columns(noise: Sequence[Images]) -> tuple[float, float, float]:
    """Cycles a row and a pixel of the strongest oblique wave, and its power."""
    _, height, width = noise[0].shape
    power = np.sum([np.square(np.abs(fft.rfft2(one))).mean(axis=0) for one in noise], axis=0)
    power[:, :2] = 0.0  # what whole rows have in common
    y, x = np.unravel_index(int(np.argmax(power)), power.shape)
    down, across = float(y) / height, float(x) / width
    reach = np.linspace(-1, 1, FINER)
    most = 0.0
    for part in (1.0, 2.0 / (FINER - 1)):
        rows, columns = down + part * reach / height, across + part * reach / width
        fine = np.sum([np.square(np.abs(_at(one, rows, columns))).mean(axis=0) for one in noise], 0)
        y, x = np.unravel_index(int(np.argmax(fine)), fine.shape)
        down, across, most = float(rows[y]), float(columns[x]), float(fine[y, x])
    return down, across, most


def _at(noise: Images, down: Floats, across: Floats) -> Phasors:
    """Fourier sums of frames (n, H, W) at frequencies: (n, down, across)."""
    _, height, width = noise.shape
    of_rows = np.exp(-2j * np.pi * np.outer(down, np.arange(height)))
    of_columns = np.exp(-2j * np.pi * np.outer(np.arange(width), across))
    return np.asarray(of_rows @ (noise @ of_columns))


def _phasors(noise: Sequence[Images], down: float, across: float) -> list[Phasors]:
    """What each frame has of a wave, one array a shot."""
    return [_at(one, np.array([down]), np.array([across]))[:, 0, 0] for one in noise]


def _steps(phasors: Sequence[Phasors], lag: int) -> Phasors:
    """Products of each frame's phasor with the one so many frames before, over all shots."""
    return np.concatenate([one[lag:] * np.conj(one[:-lag]) for one in phasors])


def _agreement(steps: Phasors) -> float:
    """Length of the mean of phasors, as a part of theirs: 1 where all have one phase."""
    return float(abs(steps.sum()) / max(float(np.abs(steps).sum()), NO_WAVE))


def _walk(phasors: Sequence[Phasors]) -> float:
    """Standard deviation of what the phase walks from frame to frame, in cycles: noise of phasors
    costs agreement at any lag, and a walk of w cycles a factor of exp(-2 pi^2 w^2) with each frame.
    """
    next_one = _agreement(_steps(phasors, 1))
    for lag in LAGS:
        later = _agreement(_steps(phasors, lag))
        if later > LEAST_AGREEMENT:
            lost = max(float(np.log(next_one / later)), 0.0) / (lag - 1)
            walk = float(np.sqrt(lost / 2) / np.pi)
            return walk if walk > LEAST_WALK else 0.0
    return 0.0


def _between(power: Floats, peak: int) -> float:
    """Place of a peak between the points of a spectrum, by the parabola of its logarithm."""
    if not 0 < peak < len(power) - 1:
        return float(peak)
    left, middle, right = np.log(power[peak - 1 : peak + 2] + 1e-30)
    bend = left - 2 * middle + right
    return float(peak + (0.5 * (left - right) / bend if bend < 0 else 0.0))


def _mosaic(stack: Frames, lattices: tuple[Lattice, ...]) -> Images:
    """Noise of measured samples in their places, each colour in units of its own."""
    dn = np.asarray(stack.dn[:HINT_FRAMES])
    plane = np.zeros(dn.shape[:3], dtype=np.float32)
    for lattice in lattices:
        channel = dn[..., "RGB".index(lattice.channel)] if dn.ndim == 4 else dn
        samples = channel[:, lattice.dy :: lattice.step, lattice.dx :: lattice.step]
        noise = samples.astype(np.float32)
        noise = noise - noise.mean(axis=0)
        size = float(noise.std()) or 1.0
        plane[:, lattice.dy :: lattice.step, lattice.dx :: lattice.step] = noise / size
    return plane
