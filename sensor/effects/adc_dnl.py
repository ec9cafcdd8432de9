"""Differential nonlinearity of the converter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.effect import Effect, Stage, parameter
from sensor.limits import between
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.whole_numbers import whole_number


@dataclass(frozen=True, kw_only=True)
class AdcDnl(Effect):
    """Codes are not equally wide: by kind of converter, in another way.

        weighed     w_i = 2^i + u sqrt(2^i) n_i, scaled so that the top code stays where it is
                    code c begins at T(c) = sum of w_i over its bits
        compared    T(c) = c + t n_c, in order
        DN' = c - 1/2 + (DN + 1/2 - T(c)) / width(c)

    A successive-approximation or pipeline converter weighs its input with bits, from the heaviest
    down; bit i is made of 2^i unit elements that match to u. Codes with equally many trailing zeros
    are off by the same amount, the middle one by a standard deviation of u sqrt(2^bits - 1) codes:
    a comb. A flash converter compares it with one voltage for each code, each off by itself by t
    codes: widths spread by t sqrt(2), and neighbouring widths have the correlation -1/2. n are
    standard normal, drawn once for the camera body. The curve is applied before rounding, so that
    nothing is rounded twice.
    """

    name: ClassVar[str] = "adc_dnl"
    stage: ClassVar[Stage] = Stage.ADC
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "Pelgrom, Analog-to-Digital Conversion (2010), binary-weighted converters: DNL of the "
        "major carry; IEEE Std 1241-2010 for DNL"
    )

    unit_mismatch: float = parameter(
        0.03,
        unit="1",
        minimum=0.0,
        maximum=0.2,
        identity=0.0,
        doc="relative standard deviation of a unit element; 0.03 is half a code at 8 bits",
    )

    threshold_sigma_dn: float = parameter(
        0.0,
        unit="DN",
        minimum=0.0,
        maximum=2.0,
        identity=0.0,
        doc="standard deviation of where each code begins, of a flash converter",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if self.unit_mismatch == 0 and self.threshold_sigma_dn == 0:
            return signal.replace(signal.value)
        bits = signal.format.bits
        weighing = np.asarray(stream.body.normal(bits).numpy()).ravel()
        begins = weighed(weighing, self.unit_mismatch)
        if self.threshold_sigma_dn > 0:
            own = np.asarray(stream.body.normal(1 << bits, use="thresholds").numpy()).ravel()
            begins = compared(begins, own, self.threshold_sigma_dn)
        ends, codes = outcomes(begins.astype(np.float32))
        per_dn, before = _cells(ends)
        most = int(np.diff(before, append=len(ends)).max())
        known: list[Any] = [codes, begins[codes], widths(begins)[codes], before]
        padded = np.append(ends, np.full(most, np.inf, dtype=np.float32))
        known += [padded[before + k] for k in range(most)]
        code, begin, width, first, *next_ends = (signal.backend.tensor(n).array for n in known)
        flat = type(code)
        last_cell = float(len(before) - 1)

        def converted(value: Any) -> Any:
            place = value + 0.5
            cell = whole_number(between(place * per_dn, 0.0, last_cell))
            number = dr.gather(flat, first, cell)
            for end in next_ends:
                number += dr.select(place >= dr.gather(flat, end, cell), 1.0, 0.0)
            found = whole_number(number)
            rest = place - dr.gather(flat, begin, found)
            part = rest / dr.select(rest < 0, 1.0, dr.gather(flat, width, found))
            return dr.gather(flat, code, found) - 0.5 + part

        return signal.pointwise(converted)


def outcomes(
    begins: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.intp]]:
    """Where a converter that decides bit by bit changes its mind, and what it says from there on.

    The first of the codes is what it says below all these places.

    Args:
        begins: where each code begins, in nominal codes, in the order of the codes.
    """
    places = np.append(np.float32(-np.inf), np.unique(begins[1:]))
    codes = np.zeros(len(places), dtype=np.intp)
    for bit in reversed(range(len(begins).bit_length() - 1)):
        trial = codes + (1 << bit)
        codes = np.where(places >= begins[trial], trial, codes)
    new = np.append(True, codes[1:] != codes[:-1])
    return places[new][1:], codes[new]


def _cells(ends: NDArray[np.float32]) -> tuple[float, NDArray[np.intp]]:
    """Cells in a nominal code, so that few ends lie in one, and the number of ends before each."""
    for per_dn in (1.0, 2.0, 4.0, 8.0):  # powers of two: a float32 is scaled without rounding
        cells = max(int(ends[-1] * per_dn), 0) + 1
        before = np.searchsorted(np.maximum(ends * per_dn, 0.0), np.arange(cells))
        before[0] = 0
        if np.diff(before, append=len(ends)).max() <= 2:
            break
    return per_dn, before


def weighed(draws: NDArray[np.float32], mismatch: float) -> NDArray[np.float64]:
    """Where each code of a converter that weighs begins, in nominal codes.

    Args:
        draws: standard normal, of each bit, lightest first.
        mismatch: of a unit element.
    """
    nominal = 2.0 ** np.arange(len(draws))
    weights = nominal + mismatch * np.sqrt(nominal) * draws
    weights *= nominal.sum() / weights.sum()
    begins = np.zeros(1)
    for weight in weights:
        begins = np.concatenate([begins, begins + weight])
    return begins


def compared(
    begins: NDArray[np.float64], draws: NDArray[np.float32], sigma_dn: float
) -> NDArray[np.float64]:
    """Where each code of a flash converter begins, in nominal codes, (codes,).

    Each beginning is off by itself, and the converter counts those that are below.

    Args:
        begins: where codes begin otherwise, in nominal codes, (codes,).
        draws: standard normal, of each code, (codes,).
        sigma_dn: of the beginnings, in nominal codes.
    """
    return np.append(begins[:1], np.sort(begins[1:] + sigma_dn * draws[1:]))


def widths(begins: NDArray[np.float64]) -> NDArray[np.float64]:
    """Widths of the codes in nominal codes.

    Where bits are not monotonic, codes go missing: the input of a code ends where any higher one
    begins. A missing code has width 1, which nothing uses.
    """
    next_above = np.minimum.accumulate(begins[::-1])[::-1]
    found = np.append(next_above[1:] - begins[:-1], 1.0)
    return np.where(found > 0, found, 1.0)
