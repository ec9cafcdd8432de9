"""Two plain diagnoses to be beaten. Both take the data sheet's camera as it is, without a refit.

histogram     the field's usual metric: marginal histograms, summed over shots and colours; the
              nearest of the camera and the camera with each effect at its default strength
refit-free    a battery of structured figures; the effect along whose signature chi-squared falls
              most. Its weakness is that a calibration error looks like an effect
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.report import FORMAT, Verdict
from camtruth.blind.format import NOMINAL
from camtruth.blind.ruler import battery
from foundation.errors import InputError
from render.rate import read_rate
from sensor import camera_file
from sensor.camera import Camera
from sensor.capture_folder import inside, read_capture, read_manifest
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.frames import Capture, Frames
from sensor.protocol import Protocol, Shot
from sensor.record import record

FRAMES = 8
SHOTS = 3
"""The longest dark and the brightest shot of each of two lamps: what simulating takes is theirs."""

BODIES = 4
MARGIN = 9.0

Floats = NDArray[np.float64]


def histogram(folder: Path, without: tuple[str, ...]) -> dict[str, Any]:
    """Nearest by the symmetric Kullback-Leibler divergence of marginal histograms."""
    real, twin = _ready(folder)
    seen = _histograms(real)
    floor = _divergence(seen, _histograms(twin.plain(0)))
    found = {
        name: _divergence(seen, _histograms(capture)) for name, _, capture in twin.suspects(without)
    }
    best = min(found, key=lambda name: found[name])
    spread = abs(_divergence(seen, _histograms(twin.plain(1))) - floor)
    named = best if found[best] < floor - max(spread, 1e-9) else None
    weights = {name: 1 / max(value, 1e-12) for name, value in found.items()}
    total = sum(weights.values())
    chances = {name: weight / total for name, weight in weights.items()}
    return _report(named, chances, 0.9, floor, found[best])


def refit_free(folder: Path, without: tuple[str, ...]) -> dict[str, Any]:
    """Largest fall of chi-squared along a signature, all figures as the data sheet has them."""
    real, twin = _ready(folder)
    bodies = np.array([battery(twin.plain(k)) for k in range(BODIES)])
    sd = np.sqrt(bodies.var(axis=0, ddof=1) + 1e-12)
    sd = np.maximum(sd, 0.3 * np.median(sd))
    gap = (battery(real) - bodies.mean(axis=0)) / sd
    falls: dict[str, float] = {}
    for name, _, capture in twin.suspects(without):
        s = (battery(capture) - bodies[0]) / sd
        falls[name] = max(0.0, float(s @ gap)) ** 2 / max(float(s @ s), 1e-12)
    order = sorted(falls, key=lambda name: -falls[name])
    named = order[0] if falls[order[0]] - falls[order[1]] > MARGIN else None
    top = falls[order[0]]
    weights = {name: float(np.exp((fall - top) / 2)) for name, fall in falls.items()}
    total = sum(weights.values())
    chances = {name: weight / total for name, weight in weights.items()}
    before = float(gap @ gap) / gap.size
    return _report(named, chances, 0.99, before, before - top / gap.size, unsure="unexplained")


class Twin:
    """The data sheet's camera under the light that the capture states."""

    def __init__(self, camera: Camera, protocol: Protocol, rates: dict[str, Any]) -> None:
        self.camera, self.protocol, self.rates = camera, protocol, rates

    def plain(self, number: int) -> Capture:
        """A capture of one of its bodies."""
        return self._taken(self.camera, number)

    def suspects(self, without: tuple[str, ...]) -> Iterator[tuple[str, type[Effect], Capture]]:
        """A capture with each effect at its default strength, where the camera can have it."""
        for name, kind in catalogue().items():
            if kind.base or name in without:
                continue
            try:
                yield name, kind, self._taken(self.camera.plus(kind()), 0)
            except InputError:
                continue

    def _taken(self, camera: Camera, number: int) -> Capture:
        return record(camera.with_body(number), self.protocol, self.rates, seed=number)


def _ready(folder: Path) -> tuple[Capture, Twin]:
    capture = read_capture(folder)
    rates = {}
    for shot in read_manifest(folder).shot:
        if shot.rate is not None:
            rates[shot.light[0]] = read_rate(inside(folder, shot.rate)).rate_e_per_s
    chosen = _chosen(capture, rates)
    few = tuple(
        Frames(
            dn=f.dn[:FRAMES],
            shot=_short(f.shot, len(f.dn[:FRAMES])),
            pixels=f.pixels,
            bits=f.bits,
            cfa=f.cfa,
        )
        for f in chosen
    )
    shots = tuple(f.shot for f in few)
    camera = camera_file.load(str(folder / NOMINAL))
    real = Capture(camera=capture.camera, frames=few, panels=capture.panels)
    return real, Twin(camera, Protocol(name="few", shot=shots), rates)


def _chosen(capture: Capture, rates: dict[str, Any]) -> list[Frames]:
    darks = sorted(capture.darks, key=lambda f: f.shot.exposure_s)[-1:]
    lit = sorted(
        (f for f in capture.lit if set(f.shot.light) <= set(rates)),
        key=lambda f: -sum(f.shot.level) * f.shot.exposure_s,
    )
    first = {f.shot.light: f for f in reversed(lit)}
    return [*darks, *first.values()][:SHOTS]


def _short(shot: Shot, frames: int) -> Shot:
    import dataclasses

    return dataclasses.replace(shot, frames=frames)


def _histograms(capture: Capture) -> Floats:
    rows = []
    for f in capture.frames:
        planes = [f.dn[..., k] for k in range(3)] if f.demosaiced else [f.dn]
        width = max(0, f.bits - 8)
        for plane in planes:
            counts = np.bincount(np.asarray(plane).ravel() >> width, minlength=256) + 0.5
            rows.append(counts / counts.sum())
    return np.array(rows)


def _divergence(one: Floats, two: Floats) -> float:
    return float(((one - two) * np.log(one / two)).sum())


def _report(
    named: str | None,
    chances: dict[str, float],
    sure: float,
    before: float,
    after: float,
    *,
    unsure: Verdict = "matched",
) -> dict[str, Any]:
    after = after if named else before
    return {
        "format": FORMAT,
        "verdict": "explained" if named else unsure,
        "effects": [
            {
                "name": named,
                "probability": max(sure, chances[named]),
                "indistinguishable_from": [],
                "absorbed": 0.0,
                "parameters": {},
            }
        ]
        if named
        else [],
        "candidates": [
            {"name": name, "probability": chance, "gap": before, "calibration_equivalent": False}
            for name, chance in sorted(chances.items(), key=lambda entry: -entry[1])
        ],
        "gap": {
            "before": before,
            "after": after,
            "floor": 0.0,
            "shrink": (before - after) / before if before > 0 else 0.0,
            "shrink_ci": None,
            "at_floor": False,
            "p_value_before": None,
            "p_value_after": None,
            "by_family": {},
            "harmed": None,
            "placebo": None,
        },
        "where": [],
        "next_capture": None,
        "seconds": 0.0,
    }
