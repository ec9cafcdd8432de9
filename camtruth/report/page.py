"""One page that holds everything: no network, no other file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.parameters import Estimate, NoiseParameters
from analysis.round_trip import Row
from camtruth.report import curves, pictures
from camtruth.report.templates import spelt, template
from camtruth.terminal import figure, rounded, with_error
from render.rate import RateImage
from sensor.camera import Camera
from sensor.catalogue import effect
from sensor.frames import Capture
from sensor.protocol import Protocol

CLEAR = 3.0
"""A bias of this many standard errors is marked."""


@dataclass(frozen=True, kw_only=True)
class Contents:
    """What a report shows.

    Attributes:
        command: the command line that makes it again.
        camera, protocol: what was simulated.
        images: rate images by lamp.
        capture: the frames.
        found: what the estimator read out of them.
        truth: the truth record.
        rows: the round trip.
        seeds: how many bodies it had.
        seconds: how long each part took, by name.
    """

    command: str
    camera: Camera
    protocol: Protocol
    images: Mapping[str, RateImage]
    capture: Capture
    found: NoiseParameters
    truth: Mapping[str, Any]
    rows: Sequence[Row]
    seeds: int
    seconds: Mapping[str, float]


def page(contents: Contents) -> str:
    """The report as HTML."""
    lamps = list(contents.images)
    return template("report.html.j2").render(
        command=contents.command,
        camera=contents.camera,
        protocol=contents.protocol,
        lamps=lamps,
        rendered=pictures.rendered(contents.images, contents.capture.areas),
        frames=pictures.frames(contents.capture),
        magnified=pictures.magnified(contents.capture),
        figures=curves.figures(contents.found, contents.truth, contents.capture),
        found=found_table(contents.found, contents.truth),
        trips=trip_table(contents.rows),
        channels=list(contents.found.channels),
        method=contents.found.method,
        warnings=contents.found.warnings,
        seeds=contents.seeds,
        truth=contents.truth,
        effects=effect_table(contents.camera),
        light=[(lamp, image.header) for lamp, image in contents.images.items()],
        seconds=contents.seconds,
    )


def found_table(found: NoiseParameters, truth: Mapping[str, Any]) -> list[dict[str, Any]]:
    """This capture: for each parameter and channel truth, this body's value, and the estimate."""
    keys = dict.fromkeys(key for findings in found.channels.values() for key in findings)
    table = []
    for key in keys:
        cells = []
        unit = ""
        for channel, findings in found.channels.items():
            finding, true = findings.get(key), truth["noise"][channel].get(key)
            told = isinstance(finding, Estimate)
            unit = finding.unit if isinstance(finding, Estimate) else unit
            cells.append(
                {
                    "truth": figure(true["population"]) if true else "–",
                    "realised": figure(true["realised"]) if true else "–",
                    "estimate": with_error(finding.value, finding.se)
                    if isinstance(finding, Estimate)
                    else "–",
                    "reason": "" if told or finding is None else getattr(finding, "reason", ""),
                }
            )
        table.append({"parameter": key, "unit": unit, "cells": cells})
    return table


def trip_table(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The round trip: a group of lines for each parameter of each method, one for each channel."""
    groups: dict[tuple[str, str], dict[str, Any]] = {}
    for row in rows:
        head = {"parameter": row.parameter, "method": row.method, "unit": row.unit, "lines": []}
        group = groups.setdefault((row.method, row.parameter), head)
        told = row.bias is not None and row.bias_se is not None
        group["lines"].append(
            {
                "channel": row.channel,
                "truth": figure(row.truth),
                "estimate": rounded(row.estimate, row.bias_se),
                "bias": rounded(row.bias, row.bias_se),
                "se": rounded(row.bias_se, row.bias_se),
                "rms": rounded(row.rms, row.bias_se),
                "coverage": "–" if row.coverage is None else f"{row.coverage:.0%}",
                "biased": told and abs(row.bias or 0.0) > CLEAR * (row.bias_se or 0.0),
                "reason": row.reason or "",
            }
        )
    return list(groups.values())


def effect_table(camera: Camera) -> list[dict[str, str]]:
    """What the camera does to light, in the order in which it does it."""
    table = []
    for one in camera.effects:
        values = [
            f"{p.name} = {spelt(one.values()[p.name])} {p.unit if p.unit != '1' else ''}".strip()
            for p in one.parameters()
        ]
        kind = effect(one.name)
        table.append(
            {
                "name": one.name,
                "stage": kind.stage.value,
                "values": "; ".join(values),
                "meaning": (kind.__doc__ or "").strip().splitlines()[0],
            }
        )
    return table
