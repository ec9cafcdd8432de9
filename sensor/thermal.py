"""How much more dark current a warmer sensor makes."""

from __future__ import annotations

from sensor.protocol import Shot

REFERENCE_C = 29.0
"""Temperature of the paper's sensor in its 22 degC room (Irie et al.), where rates are stated."""

DOUBLING_C = 8.0
"""Dark current of four industrial cameras doubles about every 8 degC between 21 and 55 degC."""


def darkness_s(shot: Shot, doubling_c: float = DOUBLING_C) -> float:
    """Exposure in which as much dark current gathers at the reference as it does in a shot:
    t 2^((T - 29 degC) / doubling).

    A shot that does not tell its temperature is taken at the reference.

    Args:
        shot: its exposure and temperature.
        doubling_c: rise of temperature that doubles dark current.
    """
    warmer = 0.0 if shot.temperature_c is None else shot.temperature_c - REFERENCE_C
    return float(shot.exposure_s * 2.0 ** (warmer / doubling_c))
