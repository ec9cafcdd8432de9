"""Pyxel's charge transfer by distorted clocking of traps, and its converter with unequal bits."""

from __future__ import annotations

import numpy as np
from pyxel.models.charge_transfer.utils_cdm import run_cdm_serial
from pyxel.models.readout_electronics.sar_adc_with_noise import apply_sar_adc_with_noise

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

SOURCE = "pyxel"
FULL_WELL_E = 20_000.0
VOLUME_CM3 = 1.6e-10
THERMAL_CM_PER_S = 1.2e7
TRANSFER_S = 8e-8
RELEASE_S = 4e-7
CROSS_SECTION_CM2 = 1e-14
"""A pixel of 5.6 um at 12 MHz, with one kind of trap that lets go after five transfers."""


def transfer(electrons: Numbers, strength: float, about: About) -> Numbers:
    """Charge trailing along the rows; `strength` is the density of the traps in 1e9 per cm3."""
    out = []
    for frame in electrons:
        kept = np.maximum(frame, 0).astype(np.float64)
        moved = run_cdm_serial(
            array=kept.copy(),
            beta=0.6,
            vg=VOLUME_CM3,
            t=TRANSFER_S,
            fwc=FULL_WELL_E,
            vth=THERMAL_CM_PER_S,
            tr=np.array([RELEASE_S]),
            nt=np.array([strength * 1e9]),
            sigma=np.array([CROSS_SECTION_CM2]),
        )
        out.append(frame + (moved - kept))
    return np.stack(out).astype(electrons.dtype)


def converter(mosaic: Numbers, strength: float, about: About) -> Numbers:
    """Successive approximation whose references are off: each bit by `strength` of a step."""
    steps = about.fixed("pyxel sar").normal(size=about.bits) * strength * 2.0**-about.bits
    out = [
        apply_sar_adc_with_noise(
            signal_2d=frame.astype(np.float64).copy(),
            num_rows=frame.shape[0],
            num_cols=frame.shape[1],
            strengths=steps * about.top_dn,
            noises=np.zeros(about.bits),
            max_volt=float(about.top_dn),
            adc_bits=about.bits,
        )
        for frame in mosaic
    ]
    return np.stack(out).astype(mosaic.dtype)


OUTSIDERS = (
    Outsider(
        name="pyxel charge transfer",
        source=SOURCE,
        answers=("charge_transfer_inefficiency",),
        stage="transfer",
        place="electrons",
        weakest=0.1,
        strongest=1e4,
        act=transfer,
        order=53,
    ),
    Outsider(
        name="pyxel converter",
        source=SOURCE,
        answers=("adc_dnl",),
        stage="adc",
        place="mosaic",
        weakest=0.01,
        strongest=3.0,
        act=converter,
        order=2,
    ),
)
