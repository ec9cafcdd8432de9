"""Bilinear demosaicing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter, switch
from sensor.interpolation import Interpolated
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Demosaic(Effect):
    """Fill in the two colours that a pixel does not see with the mean of its nearest neighbours.

    Measured samples pass unchanged; an interpolated one is the mean of 2 or 4, so its noise is
    1/sqrt(2) or 1/2 of the measured one: the paper's N_D. Borders are mirrored, which keeps the
    colour phase.

    A camera that counts in fractions rounds once, behind this. One that counts in whole numbers
    has rounded before, and rounds each mean again: then an interpolated sample is a function of
    whole neighbours, and every other mean of two is a half, so that it matters where halves go.
    One whose converter gives whole numbers but that counts in fractions from there on rounds again
    behind everything: without further processing that is the same as halves to the even number. One
    whose converter has two, four or six bits more than what leaves the camera counts in quarters,
    sixteenths or 64ths, as cameras of 10, 12 or 14 bits do that give 8: what processing makes of
    them is a comb of its own. Where it rounds behind everything, halves go to the even number,
    which then has 5 quarters and its neighbours 3, or up; means may be whole numbers of these steps
    as well.

    Some take all samples of the colour within 3 x 3 by the weights 1 2 1, a normalised convolution.
    For red and blue that is the same; a measured green becomes its mean with the mean of the four
    at its corners, of 5/16 of its variance, and two of them at each other's corner agree by 2/5.
    """

    name: ClassVar[str] = "demosaic"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 10
    base: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "Irie et al., equations (4) to (7); Knutsson and Westin, CVPR 1993, for the convolution"
    )

    arithmetic: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=11.0,
        whole=True,
        doc="0 in fractions; in whole numbers with halves 1 up, 2 even, 3 down; 4 of whole samples;"
        " of sixteenths 5, 6 up, 7 whole means; 8 to 10 quarters; 11 64ths",
    )

    corners: float = switch(
        0.0,
        doc="1 a measured green is averaged with those at its corners, 0 it passes unchanged",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return Interpolated(
            mosaic=signal, arithmetic=int(self.arithmetic), corners=bool(self.corners)
        ).signal()
