"""Noise of one panel: in time, in space, and in total by row and by column.

The four measures of section III of Irie et al. Their fits are least squares with a fixed design,
so one projection, from a QR decomposition, serves every column, row and frame at once. A stack is
read in chunks of frames, so memory does not grow with its length.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.map_error import se_of_mean
from sensor.frames import CaptureError, TooFewFrames

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

DEGREE = 2
"""Degree of the polynomial that stands for vignetting and 1/R^2 fall-off."""

CHUNK_SAMPLES = 1 << 17
"""Samples per chunk of frames: half a megabyte as float32, which a core keeps close."""

FEW_FRAMES = 8
"""Below this many frames their spread is too uncertain an error; the map's own spread is taken."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PanelNoise:
    """What one panel of one channel shows, in DN, each noise with its standard error.

    Every SD divides by its samples less one, the fits' degrees of freedom left in, as printed.

    Attributes:
        frames: frames in the stack.
        rows, columns: size of the panel's lattice.
        mean_dn: mean pixel value.
        temporal_dn: mean over pixels of the SD in time, mu(sigma_t).
        spatial_dn: SD of the mean image less a parabola per column, sigma(mu_t).
        rows_dn, columns_dn: SD of every frame less a parabola per row or column, mean over frames.
        at_zero, at_top: share of samples at 0 and at the largest code.
        residual_dn: the residuals behind `spatial_dn`, flat; what two shots share in them is the
            fixed pattern.
    """

    frames: int
    rows: int
    columns: int
    mean_dn: float
    temporal_dn: float
    temporal_se_dn: float
    spatial_dn: float
    spatial_se_dn: float
    rows_dn: float
    rows_se_dn: float
    columns_dn: float
    columns_se_dn: float
    at_zero: float
    at_top: float
    residual_dn: Floats


@functools.cache
def parabola_basis(samples: int) -> Floats:
    """Orthonormal columns that span the parabolas over equally spaced samples, (samples, 3)."""
    t = np.linspace(-1.0, 1.0, samples)
    basis = np.linalg.qr(np.vander(t, DEGREE + 1, increasing=True))[0]
    basis.setflags(write=False)
    return basis


def measure_panel(stack: NDArray[Any], top_dn: int) -> PanelNoise:
    """Measure the noise of a stack (N, h, w) of integer pixel values.

    Args:
        stack: samples of one channel on a regular lattice; may be memory-mapped.
        top_dn: the largest pixel value that the camera can give.

    Raises:
        TooFewFrames: for a single frame.
        CaptureError: for fewer than 4 rows or columns, where a parabola leaves nothing.
    """
    n, h, w = stack.shape
    if n < 2:
        raise TooFewFrames(
            f"a stack of {n} frame", "expected at least 2, for noise in time", "take more frames"
        )
    if min(h, w) <= DEGREE + 1:
        raise CaptureError(
            f"a panel with {h} x {w} samples of a channel",
            f"expected at least {DEGREE + 2} x {DEGREE + 2}, for a parabola and what it leaves",
            "make the panel larger",
        )
    mean, at_zero, at_top = _mean_image(stack, top_dn)
    across, down = parabola_basis(w), parabola_basis(h)
    pattern = mean - np.rint(mean.mean())  # an even panel then leaves exactly nothing
    residual = pattern - down @ (down.T @ pattern)
    residual_by_row = pattern - (pattern @ across) @ across.T
    across32, down32 = across.astype(np.float32), down.astype(np.float32)
    patterns = np.stack([residual_by_row.ravel(), residual.ravel()], axis=1).astype(np.float32)
    squares = np.zeros((h, w))
    in_rows: list[Floats] = []
    in_columns: list[Floats] = []
    for d in _deviations(stack, mean):
        flat = d.reshape(len(d), -1)
        squares += np.einsum("fij,fij->ij", d, d)
        # |P (m + d)|^2 = |P m|^2 + 2 (P m).d + |d|^2 - |fit of d|^2 for the projection P = 1 - fit.
        whole = np.vecdot(flat, flat)
        crossed = 2 * (flat @ patterns)
        by_row = (d.reshape(-1, w) @ across32).reshape(len(d), -1)
        by_column = (down32.T @ d).reshape(len(d), -1)
        in_rows.append(whole + crossed[:, 0] - np.vecdot(by_row, by_row))
        in_columns.append(whole + crossed[:, 1] - np.vecdot(by_column, by_column))

    sigma_t = np.sqrt(squares / (n - 1))
    spatial = _sd_of_residuals(np.sum(residual * residual), h * w)
    spatial_se = se_of_mean(residual * residual) / (2 * spatial) if spatial > 0 else 0.0
    temporal_se = se_of_mean(sigma_t) if n < FEW_FRAMES else _temporal_se(stack, mean, sigma_t)
    sigma_r = _sd_of_residuals(np.concatenate(in_rows) + np.sum(residual_by_row**2), h * w)
    sigma_c = _sd_of_residuals(np.concatenate(in_columns) + np.sum(residual**2), h * w)
    return PanelNoise(
        frames=n,
        rows=h,
        columns=w,
        mean_dn=float(mean.mean()),
        temporal_dn=float(sigma_t.mean()),
        temporal_se_dn=temporal_se,
        spatial_dn=float(spatial),
        spatial_se_dn=float(spatial_se),
        rows_dn=float(sigma_r.mean()),
        rows_se_dn=_total_se(sigma_r, float(spatial), float(spatial_se)),
        columns_dn=float(sigma_c.mean()),
        columns_se_dn=_total_se(sigma_c, float(spatial), float(spatial_se)),
        at_zero=at_zero,
        at_top=at_top,
        residual_dn=residual.ravel(),
    )


def combine(parts: tuple[PanelNoise, ...]) -> PanelNoise:
    """One panel from several lattices of the same colour, as the two greens of a mosaic.

    Pixels are pooled: SDs in time are averaged, residuals are concatenated. The lattices hold
    different pixels, so their errors are independent.
    """
    if len(parts) == 1:
        return parts[0]
    weight = np.array([part.rows * part.columns for part in parts], dtype=np.float64)
    weight /= weight.sum()

    def mean(name: str) -> float:
        return float(weight @ [getattr(part, name) for part in parts])

    def mean_se(name: str) -> float:
        return float(np.linalg.norm(weight * [getattr(part, name) for part in parts]))

    def pooled(name: str) -> tuple[float, float]:
        """Root mean square of SDs and its error: d sqrt(sum w s^2) = sum (w s / total) ds."""
        sd = np.array([getattr(part, f"{name}_dn") for part in parts])
        se = np.array([getattr(part, f"{name}_se_dn") for part in parts])
        whole = float(np.sqrt(weight @ sd**2))
        return whole, float(np.linalg.norm(weight * sd * se) / whole) if whole > 0 else 0.0

    spatial, rows, columns = pooled("spatial"), pooled("rows"), pooled("columns")
    return PanelNoise(
        frames=parts[0].frames,
        rows=parts[0].rows,
        columns=parts[0].columns,
        mean_dn=mean("mean_dn"),
        temporal_dn=mean("temporal_dn"),
        temporal_se_dn=mean_se("temporal_se_dn"),
        spatial_dn=spatial[0],
        spatial_se_dn=spatial[1],
        rows_dn=rows[0],
        rows_se_dn=rows[1],
        columns_dn=columns[0],
        columns_se_dn=columns[1],
        at_zero=mean("at_zero"),
        at_top=mean("at_top"),
        residual_dn=np.concatenate([part.residual_dn for part in parts]),
    )


def _chunks(stack: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """The frames in order, a few at a time."""
    step = max(1, CHUNK_SAMPLES // (stack.shape[1] * stack.shape[2]))
    for start in range(0, len(stack), step):
        yield np.ascontiguousarray(stack[start : start + step])


def _mean_image(stack: NDArray[Any], top_dn: int) -> tuple[Floats, float, float]:
    """Mean over frames, exact for whole pixel values; shares of samples at 0 and at the top."""
    total = np.zeros(stack.shape[1:])
    at_zero = at_top = 0
    for chunk in _chunks(stack):
        total += chunk.sum(axis=0, dtype=np.uint64)
        at_zero += int(np.count_nonzero(chunk == 0))
        at_top += int(np.count_nonzero(chunk >= top_dn))
    return total / len(stack), at_zero / stack.size, at_top / stack.size


def _deviations(stack: NDArray[Any], mean: Floats) -> Iterator[Singles]:
    """What each frame has over the mean image; small numbers, so single precision holds them.

    Panels of a level far above 0 keep their precision because the mean is split into whole
    numbers, taken off exactly, and a remainder below one step.
    """
    whole = np.rint(mean)
    near = (mean - whole).astype(np.float32)
    base = whole.astype(np.int32)
    for chunk in _chunks(stack):
        yield (chunk - base).astype(np.float32) - near


def _sd_of_residuals(sum_of_squares: Any, samples: int) -> Any:
    return np.sqrt(np.maximum(sum_of_squares, 0.0) / (samples - 1))


def _temporal_se(stack: NDArray[Any], mean: Floats, sigma_t: Floats) -> float:
    """Standard error of the mean SD in time, from how much each frame contributes to it.

    Frame f moves the mean SD by u_f / (N - 1), u_f = mean over pixels of d^2 / (2 sigma_t), so
    the spread of u_f over frames is its error, whatever correlation pixels of a frame have
    (demosaic, row noise). The SD in d^2 / sigma_t^2 is that of N frames themselves, which makes
    the spread too small by (N - 2) / (N + 1) for Gaussian noise: undone here.
    """
    n = len(stack)
    weight = np.divide(0.5, sigma_t, out=np.zeros_like(sigma_t), where=sigma_t > 0).ravel()
    weight /= weight.size
    influence = np.concatenate(
        [
            np.square(d).reshape(len(d), -1) @ weight.astype(np.float32)
            for d in _deviations(stack, mean)
        ]
    ).astype(np.float64)
    variance = n / (n - 1) ** 2 * np.var(influence, ddof=1) * (n + 1) / (n - 2)
    return float(np.sqrt(variance))


def _total_se(sigma: Floats, spatial: float, spatial_se: float) -> float:
    """Standard error of a total noise: its spread over frames, and the pattern they share.

    Total^2 = temporal^2 + pattern^2, so an error e of the pattern moves it by e pattern / total.
    """
    in_time = float(np.var(sigma, ddof=1)) / len(sigma)
    mean = float(sigma.mean())
    in_space = spatial_se * spatial / mean if mean > 0 else 0.0
    return float(np.sqrt(in_time + in_space**2))
