"""Charge transfer inefficiency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.limits import at_least, lesser
from sensor.neighbours import Runs, interleaved
from sensor.planes import Planes
from sensor.powers import power
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ChargeTransferInefficiency(Effect):
    """Traps in the registers catch charge from a packet and release it into the packets behind.

    After n transfers a packet Q has left Q n eps (Q / 10 ke-)^(beta - 1), at most half of itself,
    in the next packet behind it: first down the column, n = y + 1, then along the row, n = x + 1.
    beta = 1 is a constant share; below 1 small packets lose relatively more, because a cloud of
    charge grows more slowly than its content. What the last packet leaves goes to the overscan.

    Consequence: the trail is one-sided, away from the output, and its charge grows in proportion to
    the distance from the output and as Q^beta with the signal; trail and loss add up. A symmetric
    blur of the same width brightens both sides.
    """

    name: ClassVar[str] = "charge_transfer_inefficiency"
    stage: ClassVar[Stage] = Stage.TRANSFER
    position: ClassVar[int] = 20
    reference: ClassVar[str] = (
        "Short et al., An analytical model of radiation-induced charge transfer inefficiency for "
        "CCD detectors, MNRAS 430, 2013"
    )

    horizontal_per_transfer: float = parameter(
        3e-5,
        unit="1",
        minimum=0.0,
        maximum=1e-3,
        identity=0.0,
        starts=(3e-5, 0.0),
        doc="share of 10 ke- left behind at a transfer in the horizontal register",
    )
    vertical_per_transfer: float = parameter(
        2e-5,
        unit="1",
        minimum=0.0,
        maximum=1e-3,
        identity=0.0,
        starts=(2e-5, 0.0),
        doc="share of 10 ke- left behind at a transfer in a vertical register",
    )
    beta: float = parameter(
        0.7,
        unit="1",
        minimum=0.1,
        maximum=1.0,
        doc="power of the charge with which the trail grows",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        across = self._across(*self._down(signal))
        made = Planes(colours=(across,), shape=signal.shape, arrays=signal.backend.arrays)
        return signal.replace(made)

    def _down(self, signal: Signal) -> tuple[Runs, list[Any]]:
        """Runs after the transfers down the columns, and the pixel to the left of each.

        What a packet leaves is gone from it and found by the one behind, a row below.
        """
        planes = signal.planes
        parts = planes.colours[0]
        index = dr.uint32_array_t(type(parts[0]))
        lane = dr.arange(index, dr.width(parts[0]))
        row = lane // (planes.shape[2] // len(parts)) % planes.shape[1]
        transfers = type(parts[0])(row + 1) * self.vertical_per_transfer
        lost = [self._left(charge, transfers) for charge in parts]
        kept = [charge - left for charge, left in zip(parts, lost, strict=True)]
        held = [
            signal.replace(type(signal.value)(interleaved(n), signal.shape)) for n in (kept, lost)
        ]
        dr.eval([part.value for part in held])
        runs, behind = (Runs(part) for part in held)
        first_row = runs.places.row == 0
        return runs, [
            own + dr.select(first_row, 0.0, found)
            for own, found in zip(runs.line(0)[:-1], behind.line(-1)[:-1], strict=True)
        ]

    def _across(self, runs: Runs, charges: list[Any]) -> tuple[Any, ...]:
        """Charge of the columns of the runs after its transfers along the rows."""
        first = type(runs.flat)(runs.places.first)
        lost = [
            self._left(charge, (first + float(k)) * self.horizontal_per_transfer)
            for k, charge in enumerate(charges)
        ]
        return tuple(charges[k] - lost[k] + lost[k - 1] for k in range(1, len(charges)))

    def _left(self, charge: Any, share: Any) -> Any:
        """Charge that packets leave behind, where those of `REFERENCE_E` leave such a share."""
        if self.beta < 1.0:
            packet = at_least(charge, 1.0) * (1 / REFERENCE_E)
            share = share * power(packet, self.beta - 1.0)
        return charge * lesser(share, 0.5)


REFERENCE_E = 10_000.0
"""Charge at which the share per transfer is stated: middle of the range of a 14 to 20 ke- pixel."""
