"""Round trips of many bodies under the paper's protocol: bias and coverage of every method.

The light is the closed form's, which has no noise of its own, and only the panels are simulated.
Every result is plain data, so a run of hours lies in a file as it comes and goes on from there.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis import estimators
from analysis.bias.setting import light
from analysis.methods import method
from analysis.parameters import UNITS, CannotTell, Estimate, Finding, NoiseParameters
from analysis.round_trip import Row, round_trip
from foundation.panel import Panel
from scenes.geometry import analysis_panels
from scenes.scene import load as load_scene
from sensor.camera import Camera
from sensor.camera_file import load as load_camera
from sensor.effects.demosaic import Demosaic
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import Protocol
from sensor.protocol import load as load_protocol
from sensor.record import record
from sensor.truth import population

Told = list[float] | str
"""Value and standard error, or the reason for none."""

Plain = dict[str, dict[str, dict[str, Told]]]
"""What was told, by method, channel and key."""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A camera in front of the chart, cut down to its panels, and the methods to compare."""

    camera: Camera
    protocol: Protocol
    rates: Mapping[str, NDArray[np.float32]]
    panels: tuple[Panel, ...]
    methods: tuple[str, ...]

    @property
    def question(self) -> str:
        """What decides the results besides the seed: the camera, and the source of the estimators,
        all of it: they share modules.
        """
        sources = [
            path.read_text(encoding="utf-8")
            for path in sorted(Path(estimators.__path__[0]).rglob("*.py"))
        ]
        known = repr((self.camera, self.protocol, self.methods, sources))
        return f"{self.camera.name} by {', '.join(self.methods)}: " + _digest(known)


def bench(camera: str, methods: Sequence[str], *, raw: bool = False) -> Bench:
    """A preset camera with the paper's protocol; `raw` has its mosaic in place of colours."""
    panels = analysis_panels(load_scene("chart"))
    made = load_camera(camera)
    if raw:
        made = dataclasses.replace(made.without(Demosaic), pixels="bayer8")
    small, rates, moved = panels_only(made, light(), panels)
    protocol = load_protocol("paper")
    return Bench(camera=small, protocol=protocol, rates=rates, panels=moved, methods=tuple(methods))


def trip(shared: Bench, seed: int) -> Plain:
    """Simulate a body and measure it by every method."""
    camera = shared.camera.with_body(seed)
    taken = record(camera, shared.protocol, shared.rates, seed=seed, panels=shared.panels)
    return {name: _plain(method(name)(taken)) for name in shared.methods}


def rows(shared: Bench, results: Sequence[Plain]) -> tuple[Row, ...]:
    """Bias, RMS error and coverage of every method, channel and parameter."""
    truth = population(shared.camera, max(shot.exposure_s for shot in shared.protocol.shot))
    return round_trip(
        (truth, _parameters(name, of)) for result in results for name, of in result.items()
    )


def scaled(row: Row) -> dict[str, Any]:
    """A row, and its bias against the truth and against the scatter of single captures."""
    document = row.to_json()
    if row.bias is None or row.rms is None:
        return document
    scatter = max(row.rms**2 - row.bias**2, 0.0) ** 0.5
    return document | {
        "scatter": scatter,
        "bias_of_truth": row.bias / row.truth if row.truth else None,
        "bias_of_scatter": row.bias / scatter if scatter else None,
    }


def _plain(found: NoiseParameters) -> dict[str, dict[str, Told]]:
    return {
        channel: {
            key: [f.value, f.se] if isinstance(f, Estimate) else f.reason
            for key, f in findings.items()
        }
        for channel, findings in found.channels.items()
    }


def _parameters(name: str, of: Mapping[str, Mapping[str, Told]]) -> NoiseParameters:
    def finding(key: str, told: Told) -> Finding:
        if isinstance(told, str):
            return CannotTell(reason=told)
        return Estimate(value=told[0], se=told[1], unit=UNITS[key])

    return NoiseParameters(
        method=name,
        channels={c: {k: finding(k, v) for k, v in table.items()} for c, table in of.items()},
    )


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
