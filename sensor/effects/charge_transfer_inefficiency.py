"""Charge transfer inefficiency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.limits import at_least, lesser
from sensor.neighbours import Runs, interleaved
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
        shifted = self._down(signal, self.vertical_per_transfer)
        return self._across(shifted, self.horizontal_per_transfer)

    def _down(self, signal: Signal, per_transfer: float) -> Signal:
        """The charge after the transfers down the columns; packets ahead are one row above."""
        runs = Runs(signal)
        transfers = type(runs.flat)(runs.row + 1) * per_transfer
        before = type(runs.flat)(runs.row) * per_transfer  # none for the very first packet
        here, ahead = runs.line(0)[1:-1], runs.line(-1)[1:-1]
        return self._replaced(
            signal,
            [
                own
                - self._left(own, self._share(own), transfers)
                + self._left(other, self._share(other), before)
                for own, other in zip(here, ahead, strict=True)
            ],
        )

    def _across(self, signal: Signal, per_transfer: float) -> Signal:
        """The charge after the transfers along the rows; packets ahead stand to the left."""
        runs = Runs(signal)
        line = runs.line(0)[:-1]
        shares = [self._share(charge) for charge in line]
        after = []
        for k in range(runs.length):
            transfers = type(runs.flat)(runs.first + (k + 1)) * per_transfer
            before = type(runs.flat)(runs.first + k) * per_transfer
            lost = self._left(line[k + 1], shares[k + 1], transfers)
            after.append(line[k + 1] - lost + self._left(line[k], shares[k], before))
        return self._replaced(signal, after)

    def _replaced(self, signal: Signal, runs: list[Any]) -> Signal:
        return signal.replace(type(signal.value)(interleaved(runs), signal.shape))

    def _share(self, charge: Any) -> Any:
        """How the share that stays behind at a transfer differs from that of `REFERENCE_E`."""
        if self.beta == 1.0:
            return 1.0
        packet = at_least(charge, 1.0) * (1 / REFERENCE_E)
        return dr.exp2((self.beta - 1.0) * dr.log2(packet))

    def _left(self, charge: Any, share: Any, transfers: Any) -> Any:
        """Charge that packets leave behind in transfers of so many times the share, together."""
        return charge * lesser(transfers * share, 0.5)


REFERENCE_E = 10_000.0
"""Charge at which the share per transfer is stated: middle of the range of a 14 to 20 ke- pixel."""
