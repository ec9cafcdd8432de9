"""Demosaicers other than the bilinear one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from foundation.cores import in_order
from sensor.demosaicers import colour_demosaicing
from sensor.effect import Effect, Stage, parameter
from sensor.errors import CameraError
from sensor.frames import MOSAICS
from sensor.signal import Signal
from sensor.stream import Stream

_BORDER = 8
"""Pixels mirrored around the frame, which keeps the colour phase: an even number."""


@dataclass(frozen=True, kw_only=True)
class DemosaicOther(Effect):
    """The camera fills in missing colours by a cleverer rule than the mean of its neighbours.

        1: Malvar, a linear filter of 5 x 5 that takes gradients of the other colours along
        2: Menon, along the direction in which colour differences vary less, then refined
        3: OpenCV's edge-aware rule, along the smaller of two gradients
        4: OpenCV's variable number of gradients, from all directions that vary little
        5: the edge-aware rule on whole codes of 8 bits, whose means have their halves up

    Stands behind `demosaic`: measured samples pass that one unchanged, so they are taken from its
    result, filled in anew, and pass unchanged here too. Noise moves between the colours: Malvar's
    green at a red site has 1/4 of green's variance and 5/16 of red's, and a covariance of 1/2 of
    red's variance with the red beside it, where bilinear green has 1/4, 0 and 0.
    """

    name: ClassVar[str] = "demosaic_other"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 11
    reference: ClassVar[str] = (
        "Malvar, He and Cutler, ICASSP 2004; Menon, Andriani and Calvagno, IEEE Trans. Image "
        "Process. 16, 132 (2007), both by colour-demosaicing; OpenCV, COLOR_Bayer..._EA; Chang, "
        "Cheung and Pang, Proc. SPIE 3650 (1999), by OpenCV, COLOR_Bayer..._VNG"
    )

    algorithm: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=5.0,
        identity=0.0,
        whole=True,
        doc="0 leaves the bilinear one, 1 Malvar, 2 Menon, 3 edge-aware, 4 variable gradients,"
        " 5 edge-aware on whole codes",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        cfa = signal.format.cfa
        if not signal.coloured or cfa not in MOSAICS:
            raise CameraError(
                f"effect 'demosaic_other' in a camera without a demosaicer, mosaic {cfa}",
                f"expected three colours in every pixel from one of {', '.join(MOSAICS)}",
                "add the effect 'demosaic' (with pixels rgb8), or remove this one",
            )
        if self.algorithm == 0:
            return signal.replace(signal.value)
        fill = FILLS[int(self.algorithm) - 1]
        image = np.asarray(signal.value.numpy()).reshape(signal.shape)
        sites = signal.format.colour_index[None, :, :, None].astype(np.intp)
        mosaic = np.take_along_axis(image, sites, axis=3)[..., 0]
        wide = np.pad(mosaic, ((0, 0), (_BORDER, _BORDER), (_BORDER, _BORDER)), mode="reflect")
        inner = slice(_BORDER, -_BORDER)
        filled = in_order(lambda frame: fill(frame, cfa, signal.format.bits)[inner, inner], wide)
        return signal.from_numpy(np.stack(list(filled)))


Fill = Callable[[NDArray[np.float32], str, int], NDArray[Any]]


def _malvar(mosaic: NDArray[np.float32], cfa: str, bits: int) -> NDArray[Any]:
    return np.asarray(colour_demosaicing().demosaicing_CFA_Bayer_Malvar2004(mosaic, cfa))


def _menon(mosaic: NDArray[np.float32], cfa: str, bits: int) -> NDArray[Any]:
    return np.asarray(colour_demosaicing().demosaicing_CFA_Bayer_Menon2007(mosaic, cfa))


def _edge_aware(mosaic: NDArray[np.float32], cfa: str, bits: int) -> NDArray[Any]:
    """OpenCV works on 16-bit codes: DN are scaled up to those, and back."""
    import cv2

    scale = float(2 ** (16 - bits))
    codes = np.clip(np.round(mosaic * scale), 0, 65535).astype(np.uint16)
    filled = cv2.cvtColor(codes, getattr(cv2, f"COLOR_BAYER_{cfa}2RGB_EA"))
    return np.asarray(filled, dtype=np.float32) / scale


def _variable_gradients(mosaic: NDArray[np.float32], cfa: str, bits: int) -> NDArray[Any]:
    """OpenCV works on 8-bit codes here: no camera that fills in colours has more."""
    return _on_codes(mosaic, f"COLOR_BAYER_{cfa}2RGB_VNG")


def _edge_aware_on_codes(mosaic: NDArray[np.float32], cfa: str, bits: int) -> NDArray[Any]:
    return _on_codes(mosaic, f"COLOR_BAYER_{cfa}2RGB_EA")


def _on_codes(mosaic: NDArray[np.float32], way: str) -> NDArray[Any]:
    import cv2

    codes = np.clip(np.round(mosaic), 0, 255).astype(np.uint8)
    return np.asarray(cv2.cvtColor(codes, getattr(cv2, way)), dtype=np.float32)


FILLS: tuple[Fill, ...] = (
    _malvar,
    _menon,
    _edge_aware,
    _variable_gradients,
    _edge_aware_on_codes,
)
