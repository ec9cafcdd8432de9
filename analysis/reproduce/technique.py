"""Equations (10), (12), (14), (16) and Figs. 4 to 7: the technique on a camera that we know.

The simulated camera has the noise that the paper prints for its own. If the technique were free of
bias it would find those figures again; what it finds instead is its bias, and the closed form of
`analysis.bias.prediction` says how much of it to expect.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.bias.prediction import Make, Seen, predict
from analysis.bias.rounding import Floats
from analysis.bias.technique import parameters
from analysis.estimators.irie import irie
from analysis.estimators.parts.reading import N_D
from analysis.parameters import PAPER_KEYS, Estimate, NoiseParameters, Point
from analysis.reproduce.paper import Line, compare, printed
from foundation.panel import Panel
from sensor.camera import Camera
from sensor.colours import CHANNELS
from sensor.effects.dark_shot import DarkShot
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import Protocol
from sensor.record import record
from sensor.truth import population

Rates = Mapping[str, NDArray[np.float32]]
Table = dict[str, dict[str, float]]
"""Figures by channel and parameter."""

COMPARED = ("fpn", "read", "shot_coefficient", "shot_offset", "prnu_slope", "prnu_offset")


@dataclass(frozen=True, kw_only=True, eq=False)
class Runs:
    """The technique on many bodies.

    Attributes:
        found: what it made of each.
        truth: the parameters of the population.
        mean, se: mean of each parameter and its standard error over the bodies.
        expected: the mean in closed form.
    """

    found: tuple[NoiseParameters, ...]
    truth: Table
    mean: Table
    se: Table
    expected: Table


def run(
    camera: Camera,
    protocol: Protocol,
    rates: Rates,
    panels: Sequence[Panel],
    *,
    seeds: Sequence[int],
    progress: Callable[[int], None] = lambda seeds: None,
) -> Runs:
    """Take the protocol with a new camera body for each seed, and measure it as printed.

    At least two seeds, for a standard error.
    """
    small, own_rates, moved = panels_only(camera, rates, panels)
    found = []
    for seed in seeds:
        taken = record(small.with_body(seed), protocol, own_rates, seed=seed, panels=moved)
        found.append(irie(taken))
        progress(1)
    values = {
        c: {k: np.array([_value(f, c, k) for f in found]) for k in PAPER_KEYS} for c in CHANNELS
    }
    return Runs(
        found=tuple(found),
        truth=population(camera, max(shot.exposure_s for shot in protocol.shot)),
        mean={c: {k: float(v.mean()) for k, v in of.items()} for c, of in values.items()},
        se={
            c: {k: float(v.std(ddof=1) / math.sqrt(len(seeds))) for k, v in of.items()}
            for c, of in values.items()
        },
        expected={c: expected(camera, protocol, found[0].points, c) for c in CHANNELS},
    )


def makes(camera: Camera, longest_exposure_s: float) -> dict[str, Make]:
    """The channels of a camera of equation (1), as the closed form needs them."""
    truth, dark = population(camera, longest_exposure_s), camera.get(DarkShot)
    return {
        channel: Make(
            channel=channel,
            gain=of["gain"],
            read=of["read"],
            fpn=of["fpn"],
            prnu=of["prnu"],
            black=camera.black_dn,
            dark_e_per_s=dark.current_e_per_s if dark else 0.0,
            demosaiced=camera.pixels == "rgb8",
            top=2**camera.bits - 1,
        )
        for channel, of in truth.items()
    }


def expected(
    camera: Camera, protocol: Protocol, points: Sequence[Point], channel: str
) -> dict[str, float]:
    """What the technique should find in closed form, at the levels of these points."""
    shots = {shot.label: shot for shot in protocol.shot}
    make = makes(camera, max(shot.exposure_s for shot in protocol.shot))[channel]
    seen: list[Seen] = []
    for point in points:
        if point.channel != channel:
            continue
        shot = shots[point.shot]
        light = 0.0 if shot.dark else point.mean_dn - camera.black_dn
        seen.append(
            predict(
                make,
                shot=point.shot,
                light_dn=light,
                exposure_s=shot.exposure_s,
                frames=shot.frames,
            )
        )
    return parameters(seen, channel, demosaiced=make.demosaiced)


def lines(runs: Runs) -> tuple[Line, ...]:
    """The printed parameters beside those found, each disagreement with its reason."""
    result = []
    for key in COMPARED:
        for channel in CHANNELS:
            result.append(
                compare(
                    key,
                    runs.mean[channel][key],
                    runs.se[channel][key],
                    channel=channel,
                    expected=runs.expected[channel][key],
                    why=_why(key, channel, runs.truth[channel]),
                )
            )
    return (*result, *_rows_and_columns(runs.found))


def _why(key: str, channel: str, truth: Mapping[str, float]) -> str:
    """What makes the technique's figure differ from the one that went in, with its size."""
    read, fpn = truth["read"], truth["fpn"]
    left = math.sqrt(fpn**2 + read**2 / 100)
    k = truth["shot_coefficient"]
    true_curve = k * math.sqrt(100)
    linear = math.sqrt(read**2 + true_curve**2) - read
    texts = {
        "fpn": f"The mean of 100 frames keeps a tenth of the noise in time: {fpn:.3f} becomes"
        f" {left:.3f} in quadrature. The curve of Fig. 2, drawn for patterns that nothing stirs,"
        " then takes off a negative error that such frames do not have.",
        "read": "Rounding is corrected on the mean over sites whose noise differs by up to 2, and"
        " the curve bends between them; in red and blue some dark samples at 0 DN are cut off.",
        "shot_coefficient": "SDs are subtracted where variances add: 100 DN above black the shot"
        f" noise is {true_curve:.2f} DN, and sqrt(read² + shot²) - read leaves {linear:.2f}. What"
        " the paper prints is measured the same way, so its camera's coefficient is higher.",
        "shot_offset": "The subtraction of SDs bends the curve, which starts at the black level and"
        " not at 0 DN; a root fitted through it needs a negative offset. A Poisson camera cannot"
        f" give the printed {printed()[key].value[channel]:+.3f} by this technique.",
        "prnu_slope": "The spatial figure holds a tenth of a shot noise that grows with the level,"
        " and the offset pattern is taken off as an SD, which bends the line upwards.",
        "prnu_offset": "Near black the pattern is all offset, whose SD is taken off whole, so the"
        " line starts below zero; the printed ones start above it, as shading that no parabola"
        " follows would make them.",
    }
    return texts[key]


def _rows_and_columns(found: Sequence[NoiseParameters]) -> tuple[Line, ...]:
    """Section V.E and VI: row noise against column noise over all panels."""
    result = []
    for channel in CHANNELS:
        pairs = [_row_column(f.points, channel) for f in found]
        ratio = np.array([float(np.mean(rows / columns)) for rows, columns in pairs])
        together = np.array([float(np.corrcoef(rows, columns)[0, 1]) for rows, columns in pairs])
        for key, values in (("row_column_ratio", ratio), ("row_column_correlation", together)):
            se = float(values.std(ddof=1) / math.sqrt(len(values)))
            result.append(
                compare(
                    key,
                    float(values.mean()),
                    se,
                    channel=channel,
                    why="The lamp's gradient differs across and down, and a parabola follows it"
                    " less well one way than the other.",
                )
            )
    return tuple(result)


def _row_column(points: Sequence[Point], channel: str) -> tuple[Floats, Floats]:
    own = [p for p in points if p.channel == channel]
    return np.array([p.rows_dn or 0.0 for p in own]), np.array([p.columns_dn or 0.0 for p in own])


def components(figures: Mapping[str, float], mean_dn: float) -> dict[str, float]:
    """Fig. 7: the components of noise at a level, in DN, from the parameters of one channel."""
    return {
        "N_read": figures["read"],
        "FPN": figures["fpn"],
        "SN_ph": figures["shot_coefficient"] * math.sqrt(mean_dn) + figures["shot_offset"],
        "PRNU": figures["prnu_slope"] * mean_dn + figures["prnu_offset"],
        "N_Q": 1 / math.sqrt(12),
    }


def total_misfit(runs: Runs) -> dict[str, dict[str, float]]:
    """Fig. 6: how far the calibrated model is from measured total noise, relative, RMS.

    By channel: with the components added as equation (1) adds noises (variances), and as its
    signs stand when SDs are put in (sums of SDs).
    """
    result: dict[str, dict[str, float]] = {}
    for channel in CHANNELS:
        apart: dict[str, list[float]] = {"variances": [], "sds": []}
        for found in runs.found:
            figures = {k: _value(found, channel, k) for k in PAPER_KEYS}
            for p in found.points:
                if p.channel != channel or not p.more or "shot_dn" not in p.more or not p.rows_dn:
                    continue
                parts = components(figures, p.mean_dn)
                n_q = parts.pop("N_Q")
                n_d = N_D["spatial"][channel]
                whole = math.hypot(n_d * math.hypot(*parts.values()), n_q)
                apart["variances"].append(whole / p.rows_dn - 1)
                apart["sds"].append((n_d * sum(parts.values()) + n_q) / p.rows_dn - 1)
        result[channel] = {k: float(np.sqrt(np.mean(np.square(v)))) for k, v in apart.items()}
    return result


def _value(found: NoiseParameters, channel: str, key: str) -> float:
    finding = found.channels[channel][key]
    return finding.value if isinstance(finding, Estimate) else math.nan


def to_json(runs: Runs) -> dict[str, Any]:
    """The runs as plain data, points of the first body included."""
    return {
        "truth": runs.truth,
        "mean": runs.mean,
        "se": runs.se,
        "expected": runs.expected,
        "points": [point.to_json() for point in runs.found[0].points],
    }
