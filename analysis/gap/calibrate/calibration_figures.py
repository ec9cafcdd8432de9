"""What calibration found of the base camera, in the units of people."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.fit import Fit
from analysis.gap.report import Figure

Floats = NDArray[np.float64]

UNITS = {"gain": "DN/e-", "read": "DN", "fpn": "DN", "prnu": "1"}


def calibration_figures(known: Fit, errors: Floats) -> dict[str, dict[str, Figure]]:
    """The base camera by figure and channel, with standard errors.

    Args:
        known: the model.
        errors: of its directions, the knobs first; infinite where frames tell little.
    """
    base, found = known.base, {}
    names = [(knob.name, knob.channel) for knob in known.ways.knobs]
    pairs = zip(names, map(float, errors), strict=False)
    by_knob = {name: error for name, error in pairs if np.isfinite(error)}
    for name, values in (
        ("gain", base.gain_dn_per_e),
        ("read", np.sqrt(base.read_dn2)),
        ("fpn", np.sqrt(base.fpn_dn2)),
        ("prnu", np.sqrt(base.prnu2)),
    ):
        table = {}
        for c, channel in enumerate(base.channels):
            error = by_knob.get((name, c))
            value = float(values[c])
            if error is not None:
                # of a logarithm, or of a variance
                error = error * value if name == "gain" else error / (2 * max(value, 1e-6))
            table[channel] = Figure(value=value, se=error, unit=UNITS[name])
        found[name] = table
    found["black"] = {
        channel: Figure(value=float(base.black_dn[c]), se=by_knob.get(("black", c)), unit="DN")
        for c, channel in enumerate(base.channels)
    }
    for name, value, knob in (
        ("dark_current", base.dark_e_per_s, "dark"),
        ("dark_current_shown", base.shown_e_per_s, "shown"),
    ):
        found[name] = {"all": Figure(value=value, se=by_knob.get((knob, None)), unit="e-/s")}
    for name, variance, knob, unit in (
        ("dark_current_spread", base.dark_spread2, "spread", "e-/s"),
        ("clamp", base.clamp_e2, "clamp", "e-"),
    ):
        error, value = by_knob.get((knob, None)), variance**0.5
        se = None if error is None or value == 0 else error / (2 * value)
        found[name] = {"all": Figure(value=value, se=se, unit=unit)}
    found["dark_current_uneven"] = {
        "all": Figure(value=base.dark_uneven, se=by_knob.get(("uneven", None)), unit="1")
    }
    found["blur"] = {
        "all": Figure(value=base.blur_px2, se=by_knob.get(("blur", None)), unit="px^2")
    }
    if base.white_balance is not None:
        gains = {"R": base.white_balance.red_gain, "B": base.white_balance.blue_gain}
        found["white_balance"] = {c: Figure(value=g, se=None, unit="1") for c, g in gains.items()}
    return found
