"""Indirect inference: the camera whose frames the technique would read as the printed figures.

The technique's closed form (`analysis.bias.prediction`) maps a camera of equation (1) with a black
level to what the technique reads. Least squares over the camera's five figures finds the one that
is read as printed; where six printed figures cannot be met by five, the misfit says so.

What the paper leaves open is an assumption here: levels of the panels, 100 frames, 50 x 50 pixels,
three dark exposures with no dark current, and the order of N_Q and N_D (the text's, or that of
equations (10) and (12)).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from analysis.bias.prediction import Make, Seen, predict
from analysis.bias.rounding import Floats
from analysis.bias.technique import parameters
from analysis.estimators.parts.quantization import curve
from analysis.estimators.parts.reading import N_D

Order = Literal["text", "printed"]

KEYS = ("read", "fpn", "shot_coefficient", "shot_offset", "prnu_slope", "prnu_offset")

IN_TIME = ("read", "shot_coefficient", "shot_offset")
IN_SPACE = ("fpn", "prnu_slope", "prnu_offset")

LEVELS_DN = (4.0, 10.0, 22.0, 40.0, 62.0, 90.0, 125.0)
"""Light of the panels above black: assumed to cover what Figs. 4 and 5 show, up to 130 DN."""

FRAMES = 100
MODEL = 0.02
"""What the closed form is trusted to, as a share of a figure: its errors beside simulation."""

ERRORS: Mapping[str, float] = {
    "read": 0.003,
    "fpn": 0.006,
    "shot_coefficient": 0.004,
    "shot_offset": 0.03,
    "prnu_slope": 0.0003,
    "prnu_offset": 0.02,
}
"""Scatter of the technique's figures from capture to capture, as simulated bodies of the i400 have
it, in their units; the printed figures are of one camera and one capture."""


@dataclass(frozen=True, kw_only=True)
class Debiased:
    """A channel of the camera that is read as printed.

    Attributes:
        values, errors: of read, fpn (DN), gain (DN/e-), prnu and black (DN).
        reads_as: what the technique reads of it, by parameter.
        misfit: by parameter, printed less read in errors; chi2 is the sum of their squares.
    """

    channel: str
    order: Order
    values: Mapping[str, float]
    errors: Mapping[str, float]
    reads_as: Mapping[str, float]
    misfit: Mapping[str, float]

    @property
    def chi2(self) -> float:
        """Sum of squared misfits; one degree of freedom is left of six figures."""
        return sum(m * m for m in self.misfit.values())


def reads(channel: str, values: Mapping[str, float], order: Order) -> dict[str, float]:
    """What the technique makes of a camera, equations (10) to (16)."""
    make = Make(channel=channel, **values)  # type: ignore[arg-type]
    seen = [
        predict(make, shot=f"{light:g}", light_dn=light, exposure_s=0.03, frames=FRAMES)
        for light in (0.0, *LEVELS_DN)
    ]
    found = parameters(seen, channel, demosaiced=True)
    if order == "text":
        return {key: found[key] for key in KEYS}
    return _printed_order(seen, channel)


def _printed_order(seen: list[Seen], channel: str) -> dict[str, float]:
    """Measured less N_Q / N_D, as equations (10) and (12) print it, through to the curves."""
    time = np.array([_less_rounding(s, "temporal", channel) for s in seen])
    space = np.array([_less_rounding(s, "spatial", channel) for s in seen])
    mean = np.array([s.mean_dn for s in seen[1:]])
    ones = np.ones_like(mean)
    k = np.linalg.lstsq(np.stack([np.sqrt(mean), ones], axis=1), time[1:] - time[0], rcond=None)[0]
    p = np.linalg.lstsq(np.stack([mean, ones], axis=1), space[1:] - space[0], rcond=None)[0]
    figures = (time[0], space[0], k[0], k[1], p[0], p[1])
    return dict(zip(("read", "fpn", *KEYS[2:]), map(float, figures), strict=True))


def _less_rounding(s: Seen, kind: Literal["temporal", "spatial"], channel: str) -> float:
    at = curve(kind, gradient=not s.dark, rows=s.rows, frames=s.frames)
    measured = s.temporal_dn if kind == "temporal" else s.spatial_dn
    return measured - (measured - at.noise_before(measured)[0]) / N_D[kind][channel]


def search(channel: str, printed: Mapping[str, float], order: Order) -> Debiased:
    """The camera that is read as printed.

    Noise in time first: three figures, and three of the camera's that they hang on, read noise,
    gain and black level. Then FPN and PRNU by least squares of the three figures of space.

    Args:
        channel: R, G or B.
        printed: the figures of equations (10) to (16), by parameter.
        order: of N_Q and N_D.
    """
    error = {key: math.hypot(ERRORS[key], MODEL * printed[key]) for key in KEYS}
    values = {
        "read": printed["read"],
        "fpn": printed["fpn"],
        "gain": printed["shot_coefficient"] ** 2,
        "prnu": printed["prnu_slope"],
        "black": 0.3,
    }
    errors: dict[str, float] = {}
    for fields, keys in ((("read", "gain", "black"), IN_TIME), (("fpn", "prnu"), IN_SPACE)):
        values, found = _solve(channel, values, fields, keys, printed, error, order)
        errors |= found
    read = reads(channel, values, order)
    return Debiased(
        channel=channel,
        order=order,
        values=values,
        errors=errors,
        reads_as=read,
        misfit={key: (printed[key] - read[key]) / error[key] for key in KEYS},
    )


def _solve(
    channel: str,
    values: Mapping[str, float],
    fields: tuple[str, ...],
    keys: tuple[str, ...],
    printed: Mapping[str, float],
    error: Mapping[str, float],
    order: Order,
) -> tuple[dict[str, float], dict[str, float]]:
    """Least squares over some of the camera's figures; all but the black level are positive."""

    def at(x: Floats) -> dict[str, float]:
        own = {
            name: float(v) if name == "black" else math.exp(v)
            for name, v in zip(fields, x, strict=True)
        }
        return {**values, **own}

    def misfit(x: Floats) -> Floats:
        found = reads(channel, at(x), order)
        return np.array([(found[key] - printed[key]) / error[key] for key in keys])

    start = np.array([v if n == "black" else math.log(v) for n, v in values.items() if n in fields])
    low = [-4.0 if name == "black" else -7.0 for name in fields]
    high = [12.0 if name == "black" else 3.0 for name in fields]
    fit = least_squares(
        misfit, start, diff_step=np.full(start.size, 1e-3), max_nfev=30, bounds=(low, high)
    )
    slope = np.asarray(fit.jac, dtype=np.float64)
    spread = np.sqrt(np.diag(np.linalg.pinv(slope.T @ slope)))
    found = at(fit.x)
    errors = {
        name: float(s) if name == "black" else found[name] * float(s)
        for name, s in zip(fields, spread, strict=True)
    }
    return found, errors


def floor(channel: str, values: Mapping[str, float], order: Order) -> dict[str, float]:
    """What the technique reads of the camera without any FPN: the least that it can read."""
    return reads(channel, {**values, "fpn": 1e-3}, order)
