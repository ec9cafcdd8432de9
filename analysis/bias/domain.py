"""Where the printed technique holds: its bias in closed form, for a camera or for a measurement.

For a measurement the camera is not known, only what the technique made of it. The camera whose
figures the technique would read as those is found by taking the predicted bias off a few times;
the bias at that camera is what the reader is warned of.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from analysis.bias.prediction import Make, predict
from analysis.bias.technique import PRINTED, Technique, parameters
from analysis.parameters import Estimate, NoiseParameters, Point
from sensor.frames import Capture

LIMITS = (0.02, 0.05, 0.10)
"""Biases, as shares of the figure, that the domain is drawn for."""

KEYS = ("read", "fpn", "shot_coefficient", "prnu_slope")
ROUNDS = 10
LEVELS = 5
"""Levels of light that stand for all lit panels."""

LEAST = 1e-3
"""Share of a found figure below which the search does not go."""


def figures(
    make: Make,
    *,
    exposures_s: Sequence[float],
    levels_dn: Sequence[float],
    frames: int,
    size_px: int = 50,
    technique: Technique = PRINTED,
) -> dict[str, float]:
    """What the technique makes of a camera; darks at some exposures, lit panels at the longest."""
    longest = max(exposures_s)
    places = [(0.0, t) for t in exposures_s] + [(level, longest) for level in levels_dn]
    seen = [
        predict(
            make,
            shot=f"{light:g}",
            light_dn=light,
            exposure_s=exposure_s,
            frames=frames,
            size_px=size_px,
        )
        for light, exposure_s in places
    ]
    found = parameters(
        seen, make.channel, demosaiced=make.demosaiced, black_dn=make.black, technique=technique
    )
    return {key: found[key] for key in KEYS}


def true_figures(make: Make) -> dict[str, float]:
    """What went in, under the names of the parameters."""
    return {
        "read": make.read,
        "fpn": make.fpn,
        "shot_coefficient": make.gain**0.5,
        "prnu_slope": make.prnu,
    }


def foretold(found: NoiseParameters, capture: Capture) -> dict[str, dict[str, float]]:
    """Bias of a measurement as a share of the true figure, by channel and parameter.

    Channels that lack a figure are left out: what keeps the technique from answering is another
    matter than bias.
    """
    shots = {frames.shot.label: frames for frames in capture.frames}
    result = {}
    for channel, findings in found.channels.items():
        told = {key: f.value for key in KEYS if isinstance(f := findings.get(key), Estimate)}
        own = [point for point in found.points if point.channel == channel]
        if len(told) < len(KEYS) or min(told.values()) <= 0:
            continue
        darks = [p for p in own if shots[p.shot].shot.dark]
        lit = [p for p in own if not shots[p.shot].shot.dark]
        black = float(np.mean([p.mean_dn for p in darks]))
        result[channel] = _bias_behind(
            told,
            channel=channel,
            black=black,
            levels_dn=_levels(lit, black),
            exposures_s=sorted({shots[p.shot].shot.exposure_s for p in darks}),
            capture=capture,
        )
    return result


def _levels(lit: Sequence[Point], black: float) -> list[float]:
    levels = np.array([p.mean_dn for p in lit]) - black
    return [float(v) for v in np.quantile(levels, np.linspace(0, 1, LEVELS))]


def _bias_behind(
    told: Mapping[str, float],
    *,
    channel: str,
    black: float,
    levels_dn: Sequence[float],
    exposures_s: Sequence[float],
    capture: Capture,
) -> dict[str, float]:
    first = capture.frames[0]
    make = Make(
        channel=channel,
        gain=told["shot_coefficient"] ** 2,
        read=told["read"],
        fpn=told["fpn"],
        prnu=told["prnu_slope"],
        black=black,
        demosaiced=first.demosaiced,
        top=first.top_dn,
    )
    size = min(capture.areas[0].w, capture.areas[0].h)
    size = size if first.demosaiced or channel == "Y" else size // 2
    lit = [level for level in levels_dn if level > 0]
    for _ in range(ROUNDS):
        read = figures(
            make, exposures_s=exposures_s, levels_dn=lit, frames=first.count, size_px=size
        )
        true = true_figures(make)
        better = {key: max(true[key] + told[key] - read[key], LEAST * told[key]) for key in KEYS}
        make = dataclasses.replace(
            make,
            gain=better["shot_coefficient"] ** 2,
            read=better["read"],
            fpn=better["fpn"],
            prnu=better["prnu_slope"],
        )
    true = true_figures(make)
    return {key: (told[key] - true[key]) / true[key] for key in KEYS}


def warning(found: NoiseParameters, capture: Capture) -> tuple[str, ...]:
    """One line where the technique does not hold to 2 %, with how far it is off."""
    far = [
        f"{key} {channel} {100 * bias:+.0f} %"
        for channel, biases in foretold(found, capture).items()
        for key, bias in biases.items()
        if abs(bias) > LIMITS[0]
    ]
    if not far:
        return ()
    return (
        "outside the domain where this technique holds to 2 %; its closed form expects it to be off"
        f" by about {', '.join(far)}; '--method corrected' is not",
    )
