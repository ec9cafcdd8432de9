"""One case through the diagnosis, as plain data that a later count can judge."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.fit import around
from analysis.gap.calibrate.nuisance import Directions
from analysis.gap.camera.base import Base
from analysis.gap.diagnose import Diagnosis, diagnose
from analysis.gap.look.repeats import repeats
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import look
from analysis.gap_bench.cases import Case
from analysis.gap_bench.draw import begun, camera_of, capture_of, effects_of
from analysis.gap_bench.severity import severity_of
from analysis.identifiability.known import base_of
from analysis.identifiability.limits import Limit
from foundation.errors import InputError
from render.rate import RateImage
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.frames import Capture

Diagnose = Callable[..., Diagnosis]

EXPLAINED_CANDIDATES = 5
"""Candidates that are kept of each case."""

CALIBRATION_ERROR = 0.02
"""Of every base figure, where calibration is left out: a careful calibration of another day."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Bench:
    """What all cases share.

    Attributes:
        light: rate images by lamp, at the size of the frames.
        limits: tells the detection limits of effects in what a camera takes.
        frames: of each shot.
        unfitted: whether nulls are judged without calibration as well.
        diagnosis: what is examined.
    """

    light: Mapping[str, RateImage]
    limits: Callable[[Camera, Sequence[Effect]], Mapping[str, Limit]]
    frames: int
    unfitted: bool = True
    diagnosis: Diagnose = diagnose


def examine(bench: Bench, case: Case) -> dict[str, Any]:
    """Diagnose one case. What cannot be drawn says why, as `skipped`."""
    row: dict[str, Any] = {
        "kind": case.kind,
        "truth": list(case.effects),
        "severity": case.severity,
    }
    camera = camera_of(case, bench.light)
    own = bench.limits(camera, begun(case))
    effects = effects_of(case, own)
    if isinstance(effects, str):
        return row | {"skipped": effects}
    if len(effects) == 1:
        (limit,) = own.values()
        row |= {"severity": severity_of(case, limit), "absorbed": limit.absorbed}
    capture, camera = capture_of(case, camera, effects, bench.light, bench.frames)
    if any(effect.repeats for effect in effects) and not any(
        repeats(frames.dn).any() for frames in capture.frames
    ):
        return row | {"skipped": "none of these frames was dropped"}
    kinds = [
        kind
        for name, kind in catalogue().items()
        if not kind.base and not (case.kind == "withheld" and name in case.effects)
    ]
    try:
        report = bench.diagnosis(capture, stated=bench.light, suspects=kinds).report
    except InputError as refused:
        # an effect so strong that the frames no longer show the scene is bad input, by rights
        return row | {"skipped": str(refused)}
    gap = report.gap
    row |= {
        "parameters": {effect.name: numbers(effect) for effect in effects},
        "verdict": report.verdict,
        "named": [
            {
                "name": named.name,
                "probability": named.probability,
                "alike": list(named.indistinguishable_from),
                "absorbed": named.absorbed,
                "parameters": {
                    name: [finite(figure.value), finite(figure.se)]
                    for name, figure in named.parameters.items()
                },
            }
            for named in report.effects
        ],
        "candidates": [
            {
                "name": c.name,
                "score": finite(c.score),
                "probability": finite(c.probability),
                "calibration_equivalent": c.calibration_equivalent,
            }
            for c in report.candidates[:EXPLAINED_CANDIDATES]
        ],
        "before": finite(gap.before),
        "after": finite(gap.after),
        "shrink": finite(gap.shrink),
        "shrink_ci": [finite(v) for v in gap.shrink_ci],
        "at_floor": bool(gap.at_floor),
        "p_before": finite(gap.p_value_before),
        "p_after": finite(gap.p_value_after),
        "seconds": round(report.seconds, 1),
    }
    if case.kind == "null" and bench.unfitted:
        row["p_unfitted"] = finite(unfitted(capture, camera, bench.light, case.number))
    return row


def unfitted(
    capture: Capture, camera: Camera, light: Mapping[str, RateImage], number: int
) -> float:
    """Chance of a capture's distance from its own camera, where nothing may be calibrated.

    The camera is known as well as one knows a camera from another day, not better.
    """
    setting = look(capture, light)
    assert setting is not None, "the bench takes enough frames"
    known = off_by_a_little(base_of(camera, list(light)), number)
    fit = around(known, setting.scenery)
    fixed = dataclasses.replace(fit, ways=nothing(fit.ways))
    return measured(fixed, setting.seen).whole.p_value


def off_by_a_little(base: Base, number: int) -> Base:
    """A base each of whose figures is off by 2 % of itself, one standard deviation."""
    draw = np.random.default_rng(number + 1)

    def off(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(values * np.exp(draw.normal(0, CALIBRATION_ERROR, np.shape(values))))

    return dataclasses.replace(
        base,
        gain_dn_per_e=off(base.gain_dn_per_e),
        read_dn2=off(off(base.read_dn2)),
        fpn_dn2=off(off(base.fpn_dn2)),
        prnu2=off(off(base.prnu2)),
        black_dn=off(base.black_dn),
        dark_e_per_s=float(off(np.array(base.dark_e_per_s))),
        level={lamp: off(level) for lamp, level in base.level.items()},
    )


def nothing(ways: Directions) -> Directions:
    """No direction at all: one that leads nowhere stands in for none."""
    return Directions(
        knobs=(),
        tuned=(),
        figures=np.zeros((1, *ways.figures.shape[1:])),
        means=np.zeros((1, *ways.means.shape[1:])),
        prior=np.ones(1),
    )


def numbers(effect: Effect) -> dict[str, float]:
    """Parameters of an effect that are one number each."""
    return {
        name: float(value)
        for name, value in effect.values().items()
        if isinstance(value, (int, float))
    }


def finite(value: float | None) -> float | None:
    """A figure that JSON knows: None in place of infinity and of what is no number."""
    return float(value) if value is not None and math.isfinite(value) else None
