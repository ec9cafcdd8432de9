"""One cell of the study: some bodies, every estimator, bias beside its prediction."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from analysis.methods import method
from analysis.parameters import UNITS, Estimate, Finding, NoiseParameters
from analysis.study.bench import BRIGHTEST_DN8, Bench, bench, panel_light
from analysis.study.design import Case
from analysis.study.prediction import predict
from sensor.record import record

KEYS = ("read", "gain", "fpn", "prnu")
ALIASES: Mapping[str, str] = {"gain": "shot_coefficient", "fpn": "dsnu", "prnu": "prnu_slope"}
"""What a method that does not report a parameter reports in its place: the gain is the square of
the shot coefficient, the others are the same figure under another name."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What all cells share: how many bodies, and names of the estimators."""

    bodies: int
    methods: tuple[str, ...]


def run_case(plan: Plan, case: Case) -> list[dict[str, Any]]:
    """Rows of one cell, a row for each channel, estimator and parameter; plain data."""
    made = bench(case)
    found: dict[str, list[NoiseParameters]] = {name: [] for name in plan.methods}
    first = zlib.crc32(case.key.encode()) * plan.bodies  # other bodies in every cell
    for seed in range(first, first + plan.bodies):
        camera = made.camera.with_body(seed)
        taken = record(camera, made.protocol, made.rates, seed=seed, panels=[made.panel])
        for name in plan.methods:
            found[name].append(method(name)(taken))
    rows = []
    for channel in "RGB":
        ahead = predict(made, channel)
        for name in plan.methods:
            for key in KEYS:
                expected = _predicted(ahead.get(name, {}), key)
                tries = [_told(of.channels[channel], key) for of in found[name]]
                known = _place(case, made, channel)
                rows.append(known | _row(name, key, made.truth[key], tries, expected))
    return rows


def _place(case: Case, made: Bench, channel: str) -> dict[str, Any]:
    light, panel = panel_light(case.place, case.lamp)
    share = float(light[panel.window][..., "RGB".index(channel)].mean())
    rise_steps = made.rise_dn8[channel] / case.step_dn8
    return asdict(case) | {
        "channel": channel,
        "level_dn8": BRIGHTEST_DN8 * share,
        "rise_dn8": made.rise_dn8[channel],
        "rise_steps": rise_steps,
        "ramp_variance_steps2": rise_steps**2 / 12,
    }


def _row(
    name: str, key: str, truth: float, tries: Sequence[float | None], expected: float | None
) -> dict[str, Any]:
    values = np.array([v for v in tries if v is not None])
    given = values.size
    scatter = float(values.std(ddof=1)) if given > 1 else None
    return {
        "method": name,
        "parameter": key,
        "unit": UNITS[key],
        "truth": truth,
        "estimate": float(values.mean()) if given else None,
        "bias": float(values.mean()) - truth if given else None,
        "bias_se": scatter / math.sqrt(given) if scatter is not None else None,
        "scatter": scatter,
        "answered": given / len(tries),
        "predicted_bias": None if expected is None else expected - truth,
    }


def _told(findings: Mapping[str, Finding], key: str) -> float | None:
    for name in (key, ALIASES.get(key, key)):
        finding = findings.get(name)
        if isinstance(finding, Estimate):
            square = key == "gain" and name == "shot_coefficient"
            return finding.value * abs(finding.value) if square else finding.value
    return None


def _predicted(figures: Mapping[str, float], key: str) -> float | None:
    if key in figures:
        return figures[key]
    other = figures.get(ALIASES.get(key, key))
    return other * abs(other) if other is not None and key == "gain" else other
