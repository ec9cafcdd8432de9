"""JPEG compression."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from foundation.cores import in_order
from sensor.effect import Effect, Stage, parameter
from sensor.errors import CameraError
from sensor.signal import Signal
from sensor.stream import Stream

SUBSAMPLINGS = ("4:4:4", "4:2:2", "4:2:0")


@dataclass(frozen=True, kw_only=True)
class Jpeg(Effect):
    """Every frame is compressed by a real codec, libjpeg through Pillow, and unpacked again.

        DN' = decode(encode(DN, quality)):    DCT of 8 x 8 blocks, q(u, v) round(DCT / q(u, v))

    Colours are carried at full resolution, at half of it along rows (4:2:2, as in cameras), or at
    half of it both ways. The cosine coefficients of the blocks fall on combs whose spacing is the
    table q; noise below half a step vanishes and gradients jump from block to block. A blur keeps
    no grid of 8 pixels. No quality is without loss: to have none, leave the effect out.
    """

    name: ClassVar[str] = "jpeg"
    stage: ClassVar[Stage] = Stage.TRANSPORT
    position: ClassVar[int] = 20
    reference: ClassVar[str] = (
        "ITU-T T.81 | ISO/IEC 10918-1; tables of its annex K as libjpeg scales"
    )

    quality: float = parameter(
        90.0,
        unit="1",
        minimum=1.0,
        maximum=100.0,
        whole=True,
        starts=(93.0, 65.0, 20.0),
        doc="libjpeg's quality: 100 has steps of 1, 50 the tables of the standard",
    )
    subsampling: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=2.0,
        whole=True,
        starts=(1.0, 0.0, 2.0),
        doc="of the colours: 0 none, 1 is 4:2:2, 2 is 4:2:0",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        mosaic = not signal.coloured and len(set(signal.format.cfa)) > 1
        if signal.format.bits != 8 or mosaic:
            raise CameraError(
                f"effect 'jpeg' on {'a mosaic' if mosaic else 'pixels'} "
                f"of {signal.format.bits} bits",
                "expected rgb8 or mono8 pixels of 8 bits",
                "change 'pixels' and 'bits', or remove the effect",
            )
        codes = np.asarray(signal.value.numpy()).reshape(signal.shape).astype(np.uint8)
        return signal.from_numpy(np.stack(list(in_order(self._there_and_back, codes))))

    def _there_and_back(self, frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
        from PIL import Image

        packed = io.BytesIO()
        options: dict[str, Any] = {}
        if frame.ndim == 3:
            options["subsampling"] = SUBSAMPLINGS[int(self.subsampling)]
        Image.fromarray(frame).save(packed, "JPEG", quality=int(self.quality), **options)
        packed.seek(0)
        with Image.open(packed) as image:
            return np.asarray(image)
