"""The two conversions that every camera makes: light to charge, and charge to numbers."""

from __future__ import annotations

import drjit as dr

from sensor.sampled import Sampled
from sensor.signal import Quantity, Signal


def expose(signal: Signal) -> Signal:
    """Integrate the light and look through the colour filters.

    electrons(y, x) = rate(y, x, colour of (y, x)) x exposure: a mean, before its shot noise.
    """
    exposure_s = float(signal.shot.exposure_s)
    if isinstance(signal.numbers, Sampled):
        seen = signal.replace(signal.numbers.mosaic(signal.format.cfa))
        return seen.pointwise(lambda rate: rate * exposure_s, quantity=Quantity.ELECTRONS)
    f, height, width, _ = signal.shape
    flat = signal.value.array
    charge = dr.gather(type(flat), flat, signal.mosaic_index()) * exposure_s
    value = type(signal.value)(charge, (f, height, width))
    return signal.replace(value, quantity=Quantity.ELECTRONS)


def digitise(signal: Signal) -> Signal:
    """Amplify and offset: DN = gain x (electrons - clamped dark charge) + black level.

    The converter's rounding is the effect `quantization`.
    """
    clamp_e, black_dn = signal.clamp_e, signal.format.black_dn
    return signal.pointwise(
        lambda e, gain, clamp, black: (e - clamp) * gain + black,
        signal.format.gain_dn_per_e,
        clamp_e,
        black_dn,
        quantity=Quantity.DN,
        clamp_e=0.0,
    )
