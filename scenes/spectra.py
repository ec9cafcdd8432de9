"""Spectra: lamps, reflectances and camera responses, linear between their samples.

Lamp spectra and charts come from colour-science by name, or from a CSV file whose header is
``nm,value`` (a lamp) or ``nm,R,G,B`` (a camera). Lines that start with ``#`` are provenance.
A spectrum covers 400 to 700 nm; lamps are sampled every 5 nm or finer, because a coarser table
flattens mercury lines; reflectances and responses, which are smooth, every 10 nm or finer.
"""

from __future__ import annotations

import csv
import functools
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foundation.documents import read_text
from foundation.errors import unknown
from scenes.colour_science import colour
from scenes.errors import SpectrumError

VISIBLE_NM = (400.0, 700.0)
"""What every spectrum has to cover."""

BAND_NM = (380.0, 780.0)
"""What is rendered; a camera has to be blind outside, as behind an infrared cut filter."""

COARSEST_LAMP_NM = 5.0
COARSEST_SMOOTH_NM = 10.0
BLIND = 0.01
"""A response below this part of its peak counts as none."""

CHANNELS = ("R", "G", "B")
SURROGATE = "surrogate"


@dataclass(frozen=True, kw_only=True, eq=False)
class Spectrum:
    """A quantity against wavelength: linear between its samples, nothing outside them."""

    nm: NDArray[np.float64]
    value: NDArray[np.float64]

    def at(self, nm: ArrayLike) -> NDArray[np.float64]:
        """The quantity at some wavelengths in nm."""
        where = np.asarray(nm, dtype=np.float64)
        return np.asarray(np.interp(where, self.nm, self.value, left=0.0, right=0.0))

    def integral(self, low_nm: float = BAND_NM[0], high_nm: float = BAND_NM[1]) -> float:
        """The integral over wavelength, exact for what is linear between samples."""
        inside = self.nm[(self.nm > low_nm) & (self.nm < high_nm)]
        nodes = np.concatenate([[low_nm], inside, [high_nm]])
        return float(np.trapezoid(self.at(nodes), nodes))

    def times(self, factor: ArrayLike) -> Spectrum:
        """The spectrum scaled, by a number or sample by sample."""
        return spectrum(self.nm, self.value * np.asarray(factor, dtype=np.float64))


def spectrum(nm: ArrayLike, value: ArrayLike) -> Spectrum:
    """A read-only spectrum of two equally long sequences."""
    arrays = np.array(nm, dtype=np.float64), np.array(value, dtype=np.float64)
    for array in arrays:
        array.setflags(write=False)
    return Spectrum(nm=arrays[0], value=arrays[1])


def checked(nm: ArrayLike, value: ArrayLike, source: str, coarsest_nm: float) -> Spectrum:
    """A spectrum that can be trusted in an integral.

    Raises:
        SpectrumError: for values that are negative or not numbers, wavelengths that do not rise,
            samples too far apart, or a range short of 400 to 700 nm.
    """
    result = spectrum(nm, value)
    mend = "correct the table, or choose another spectrum"
    if not (np.isfinite(result.nm).all() and np.isfinite(result.value).all()):
        raise SpectrumError(f"{source} holds NaN or infinity", "expected finite numbers", mend)
    if result.nm.size < 2 or (np.diff(result.nm) <= 0).any():
        raise SpectrumError(f"the wavelengths of {source} do not rise", "expected them to", mend)
    if result.value.min() < 0:
        at = result.nm[int(result.value.argmin())]
        raise SpectrumError(
            f"{source} is {result.value.min():g} at {at:g} nm", "expected no negative value", mend
        )
    if result.nm[0] > VISIBLE_NM[0] or result.nm[-1] < VISIBLE_NM[1]:
        raise SpectrumError(
            f"{source} covers {result.nm[0]:g} to {result.nm[-1]:g} nm",
            f"expected at least {VISIBLE_NM[0]:g} to {VISIBLE_NM[1]:g} nm",
            "give a table that covers them",
        )
    coarsest = float(np.diff(result.nm).max())
    if coarsest > coarsest_nm * (1 + 1e-9):
        raise SpectrumError(
            f"{source} has samples {coarsest:g} nm apart",
            f"expected {coarsest_nm:g} nm or less",
            "give a finer table",
        )
    if not result.value.any():
        raise SpectrumError(f"{source} is zero everywhere", "expected some light", mend)
    return result


def _table(path: Path, columns: tuple[str, ...]) -> NDArray[np.float64]:
    """The rows of a CSV table whose header is `columns`."""
    lines = [x for x in read_text(path).splitlines() if x.strip() and not x.startswith("#")]
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines)]
    if not rows or tuple(rows[0]) != columns:
        found = ",".join(rows[0])[:60] if rows else "nothing"
        raise SpectrumError(
            f"{path} begins with '{found}'",
            f"expected the header '{','.join(columns)}'",
            "name its columns in the first line",
        )
    try:
        table = np.array([[float(cell) for cell in row] for row in rows[1:]], dtype=np.float64)
    except ValueError as problem:
        raise SpectrumError(
            f"{path}: {problem}", "expected a number in every cell", "correct the table"
        ) from None
    if table.ndim != 2 or table.shape[1] != len(columns):
        raise SpectrumError(
            f"{path} has no rows of {len(columns)} numbers", "expected a table", "correct the table"
        )
    return table


@functools.cache
def lamp_spectrum(name: str) -> Spectrum:
    """The relative spectral power of a lamp; its integral over 400 to 700 nm is 1 (unit 1/nm).

    Raises:
        SpectrumError: for an unknown name or an unusable table.
    """
    if name.endswith(".csv"):
        table = _table(Path(name), ("nm", "value"))
        nm, value = table[:, 0], table[:, 1]
    else:
        known: Any = {**colour.SDS_LIGHT_SOURCES, **colour.SDS_ILLUMINANTS}
        if name not in known:
            raise unknown("lamp spectrum", name, known, SpectrumError)
        nm, value = known[name].wavelengths, known[name].values
    result = checked(nm, value, f"lamp spectrum '{name}'", COARSEST_LAMP_NM)
    return result.times(1 / result.integral(*VISIBLE_NM))


@functools.cache
def reflectances(chart: str) -> tuple[Spectrum, ...]:
    """The reflectances of the 24 panels of a ColorChecker, in panel order.

    `chart` is a name of colour-science or the path of a CSV file ``nm,1,2,...,24``. Brought to
    5 nm by Sprague's interpolation; beyond its table a reflectance keeps its last value.

    Raises:
        SpectrumError: for an unknown chart, one without 24 panels, or an unusable table.
    """
    if chart.endswith(".csv"):
        table = _table(Path(chart), ("nm", *(str(number) for number in range(1, 25))))
        named = {n: (table[:, 0], table[:, n]) for n in range(1, 25)}
    else:
        charts = colour.SDS_COLOURCHECKERS
        if chart not in charts:
            raise unknown("table of reflectances", chart, list(charts), SpectrumError)
        panels = list(charts[chart].values())
        if len(panels) < 24:
            raise SpectrumError(
                f"chart '{chart}' has {len(panels)} panels", "expected 24", "choose another chart"
            )
        named = {n: (p.wavelengths, p.values) for n, p in enumerate(panels[:24], start=1)}
    return tuple(
        _reflectance(nm, value, f"panel {number} of '{chart}'")
        for number, (nm, value) in named.items()
    )


def _reflectance(nm: ArrayLike, value: ArrayLike, source: str) -> Spectrum:
    """One reflectance at 5 nm over the band, proved to be between 0 and 1."""
    coarse = checked(nm, value, source, COARSEST_SMOOTH_NM)
    if coarse.value.max() > 1:
        raise SpectrumError(
            f"{source} reflects {coarse.value.max():g}", "expected at most 1", "correct it"
        )
    shape = colour.SpectralShape(*BAND_NM, 5)
    fine = colour.SpectralDistribution(coarse.value, coarse.nm).align(
        shape, extrapolator_kwargs={"method": "Constant"}
    )
    # Interpolation may overshoot a table of zeros and ones by a little.
    return spectrum(fine.wavelengths, np.clip(fine.values, 0.0, 1.0))


@functools.cache
def response(name: str, infrared_cut: str | None = None) -> dict[str, Spectrum]:
    """The quantum response of the three channels, relative to the tallest value of the three.

    Args:
        name: ``surrogate`` or the path of a CSV file ``nm,R,G,B``.
        infrared_cut: the path of a CSV file ``nm,value`` with the transmission of a filter that
            stands before the sensor; the tallest value is that behind the filter.

    Raises:
        SpectrumError: for an unknown name, an unusable table, a filter that transmits more than
            1, or a camera that sees infrared.
    """
    if name == SURROGATE:
        path = Path(str(resources.files("scenes") / "data" / f"{SURROGATE}.csv"))
    elif name.endswith(".csv"):
        path = Path(name)
    else:
        raise unknown("camera response", name, [SURROGATE, "FILE.csv"], SpectrumError)
    table = _table(path, ("nm", *CHANNELS))
    sources = {c: f"channel {c} of camera response '{name}'" for c in CHANNELS}
    curves = {
        channel: checked(table[:, 0], table[:, column], sources[channel], COARSEST_SMOOTH_NM)
        for column, channel in enumerate(CHANNELS, start=1)
    }
    if infrared_cut is not None:
        glass = transmission_table(infrared_cut)
        curves = {channel: _behind(glass, curve) for channel, curve in curves.items()}
    peak = max(float(curve.value.max()) for curve in curves.values())
    for channel, curve in curves.items():
        outside = (curve.nm < BAND_NM[0]) | (curve.nm > BAND_NM[1])
        if (curve.value[outside] > BLIND * peak).any():
            raise SpectrumError(
                f"{sources[channel]} sees light outside {BAND_NM[0]:g} to {BAND_NM[1]:g} nm",
                f"expected less than {BLIND:.0%} of the peak there",
                "name the camera's infrared cut filter as infrared_cut",
            )
    return {channel: curve.times(1 / peak) for channel, curve in curves.items()}


@functools.cache
def transmission_table(name: str) -> Spectrum:
    """The transmission of a filter from a CSV file ``nm,value``.

    Raises:
        SpectrumError: for an unusable table, or one above 1.
    """
    if not name.endswith(".csv"):
        raise unknown("filter", name, ["FILE.csv"], SpectrumError)
    table = _table(Path(name), ("nm", "value"))
    result = checked(table[:, 0], table[:, 1], f"filter '{name}'", COARSEST_SMOOTH_NM)
    if result.value.max() > 1:
        raise SpectrumError(
            f"filter '{name}' transmits {result.value.max():g}", "expected at most 1", "correct it"
        )
    return result


def _behind(glass: Spectrum, curve: Spectrum) -> Spectrum:
    """A response behind a filter, on a grid of 1 nm: dark where the filter's table ends."""
    nm = np.unique(np.concatenate([np.arange(curve.nm[0], curve.nm[-1]), curve.nm]))
    return spectrum(nm, curve.at(nm) * glass.at(nm))
