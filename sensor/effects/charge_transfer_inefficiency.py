"""Charge transfer inefficiency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.neighbours import Neighbours
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
        doc="share of 10 ke- left behind at a transfer in the horizontal register",
    )
    vertical_per_transfer: float = parameter(
        2e-5,
        unit="1",
        minimum=0.0,
        maximum=1e-3,
        identity=0.0,
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
        shifted = self.trailing(signal, self.vertical_per_transfer, dy=1, dx=0)
        return self.trailing(shifted, self.horizontal_per_transfer, dy=0, dx=1)

    def trailing(self, signal: Signal, per_transfer: float, *, dy: int, dx: int) -> Signal:
        """The charge after the transfers in one direction; packets behind are at (dy, dx)."""
        near = Neighbours(signal)
        transfers = near.row + 1 if dy else near.column + 1
        ahead = near.flat_at(-dy, -dx)
        left = self.left(near.flat, transfers, per_transfer)
        received = self.left(ahead, transfers - 1, per_transfer)  # none for the very first packet
        return signal.replace(near.tensor(near.flat - left + received, signal.shape))

    def left(self, charge: Any, transfers: Any, per_transfer: float) -> Any:
        """Charge that packets leave behind in so many transfers; flat."""
        share = type(charge)(transfers) * per_transfer
        if self.beta != 1.0:
            packet = dr.maximum(charge, 1.0) * (1 / REFERENCE_E)
            share = share * dr.exp2((self.beta - 1.0) * dr.log2(packet))
        return charge * dr.minimum(share, 0.5)


REFERENCE_E = 10_000.0
"""Charge at which the share per transfer is stated: middle of the range of a 14 to 20 ke- pixel."""
