"""Cases in which an estimator, or the simulator that tests it, goes wrong: found in real projects.

Each is simulated where the truth is known, and told as data for the bias page.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from analysis.bias.rounding import ROUNDING_DN2, Floats
from analysis.bias.setting import light
from analysis.estimators.correction.cells import measure_cell
from analysis.methods import method
from analysis.parameters import Estimate
from analysis.study.bench import bench as study_bench
from analysis.study.design import LAMP_PLACES, Case
from scenes.geometry import analysis_panels
from scenes.scene import load as load_scene
from sensor.camera_file import load, with_setting
from sensor.effects.demosaic import Demosaic
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import load as load_protocol
from sensor.record import record

METHODS = ("irie", "emva1288", "photon_transfer", "corrected")


def ramps(seeds: Sequence[int]) -> list[dict[str, Any]]:
    """A ramp of light read as PRNU, by who takes no shading off: green, 10 bits."""
    rows = []
    for place in LAMP_PLACES:
        case = Case(
            place=place,
            lamp="fluorescent",
            bits=10,
            electrons_per_dn8=20.0,
            noise_steps=1.0,
            blur_px=0.0,
        )
        made = study_bench(case)
        found: dict[str, list[float]] = {}
        for seed in seeds:
            camera = made.camera.with_body(seed)
            taken = record(camera, made.protocol, made.rates, seed=seed, panels=[made.panel])
            for name in METHODS:
                of = method(name)(taken).channels["G"]
                told = of.get("prnu", of.get("prnu_slope"))
                if isinstance(told, Estimate):
                    found.setdefault(name, []).append(told.value)
        share = made.rise_dn8["G"] / 150.0
        rows.append({"rise": share, "truth": made.truth["prnu"], "read": _means(found)})
    return rows


def none_at_all(seeds: Sequence[int]) -> dict[str, Any]:
    """PRNU reported of a camera that has none: raw i400, by channel and method."""
    camera = with_setting(load("i400"), "prnu.ratio=0").without(Demosaic)
    camera = dataclasses.replace(camera, pixels="bayer8")
    panels = analysis_panels(load_scene("chart"))
    small, rates, moved = panels_only(camera, light(), panels)
    protocol = load_protocol("paper")
    found: dict[str, dict[str, list[float]]] = {c: {} for c in "RGB"}
    for seed in seeds:
        taken = record(small.with_body(seed), protocol, rates, seed=seed, panels=moved)
        for name in METHODS:
            for channel, of in method(name)(taken).channels.items():
                told = of.get("prnu", of.get("prnu_slope"))
                if isinstance(told, Estimate):
                    found[channel].setdefault(name, []).append(told.value)
    counts = {c: {name: len(v) for name, v in of.items()} for c, of in found.items()}
    return {"seeds": len(seeds), "told": counts, "read": {c: _means(of) for c, of in found.items()}}


def rounding(noises_dn: Sequence[float]) -> list[dict[str, float]]:
    """Frames rounded once, rounded twice (dithered to codes, scaled by 0.8, rounded), truncated.

    Told are mean and noise by the plain way, variance less 1/12, and by the likelihood of codes.
    """
    rng = np.random.default_rng(1)
    side, frames, level = 40, 200, 60.3
    row, column = (a.ravel().astype(np.float64) for a in np.indices((side, side)))
    rows = []
    for noise in noises_dn:
        analogue = level + noise * rng.normal(size=(frames, side, side))
        ways = {
            "once": np.rint(analogue),
            "twice": np.rint(0.8 * np.rint(analogue / 0.8)),
            "truncated": np.floor(analogue),
        }
        told: dict[str, float] = {"noise": noise}
        for name, codes in ways.items():
            cell = measure_cell(np.clip(codes, 0, 255).astype(np.uint8), 255, row, column)
            plain = float(codes.var(axis=0, ddof=1).mean()) - ROUNDING_DN2
            told[f"{name} mean"] = float(codes.mean()) - level
            told[f"{name} plain"] = max(plain, 0.0) ** 0.5
            told[f"{name} likelihood"] = cell.variance_dn2**0.5 if cell.told else 0.0
        rows.append(told)
    return rows


def tell_map(noises_dn: Floats, blacks_dn: Floats, seeds: int = 6) -> list[dict[str, float]]:
    """Where 8-bit dark frames tell their noise: share of captures, and the figure's error."""
    rng = np.random.default_rng(2)
    side, frames, pattern = 25, 100, 0.15
    row, column = (2 * a.ravel().astype(np.float64) for a in np.indices((side, side)))
    rows = []
    for noise in noises_dn:
        for black in blacks_dn:
            ratio = []
            for _ in range(seeds):
                mean = black + pattern * rng.normal(size=(side, side))
                dn = np.rint(mean + noise * rng.normal(size=(frames, side, side)))
                cell = measure_cell(np.clip(dn, 0, 255).astype(np.uint8), 255, row, column)
                if cell.told and cell.at_zero < 0.5:
                    ratio.append(cell.variance_dn2**0.5 / noise)
            rows.append(
                {
                    "noise": float(noise),
                    "black": float(black),
                    "told": len(ratio) / seeds,
                    "ratio": float(np.mean(ratio)) if ratio else 0.0,
                }
            )
    return rows


def _means(found: dict[str, list[float]]) -> dict[str, float]:
    return {name: float(np.mean(values)) for name, values in found.items()}
