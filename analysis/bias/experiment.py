"""The technique on simulated panels in one setting, many bodies: one cell of the bias page.

A setting is plain data, so that a cell can run in any process and its result lies in a file. Frames
are rounded here and not in the camera, because the step of rounding is one of the things that
vary; figures are in steps inside and in DN of the 8-bit camera outside.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.bias.prediction import Make, Seen, predict
from analysis.bias.setting import KEYS, Setting, light, truth
from analysis.bias.technique import PRINTED, Technique, parameters
from analysis.bias.two_noises import two_noises
from foundation.panel import Panel
from scenes.geometry import analysis_panels
from scenes.scene import load as load_scene
from sensor.camera import Camera
from sensor.colours import CHANNELS
from sensor.effects.dark_shot import DarkShot
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import Shot
from sensor.record import batches
from sensor.signal import Quantity
from sensor.simulation import simulate

POWER_OF_STEP = {"shot_coefficient": 0.5, "prnu_slope": 0.0}
"""How a figure in steps becomes one in DN: by the step to this power, 1 for the others."""


def measure(setting: Setting, seed: int) -> dict[str, list[Seen]]:
    """Every panel of every shot of one body by channel, in steps."""
    panels = analysis_panels(load_scene("chart"), size_px=setting.size_px)
    camera, rates, moved = panels_only(setting.made(), light(), panels)
    rates = {lamp: _sloped(rate, moved, setting.gradient) for lamp, rate in rates.items()}
    seen: dict[str, list[Seen]] = {c: [] for c in CHANNELS}
    for shot in setting.protocol().shot:
        codes = _codes(camera.with_body(seed), shot, rates, seed, setting)
        for panel in moved:
            for channel in CHANNELS:
                stacks = _lattices(codes, camera, panel, channel)
                mean, temporal, spatial = two_noises(stacks)
                seen[channel].append(
                    Seen(
                        shot=shot.label,
                        dark=shot.dark,
                        exposure_s=shot.exposure_s,
                        frames=shot.frames,
                        rows=stacks[0].shape[1],
                        mean_dn=mean,
                        temporal_dn=temporal,
                        spatial_dn=spatial,
                    )
                )
    return seen


def _codes(
    camera: Camera,
    shot: Shot,
    rates: Mapping[str, NDArray[np.float32]],
    seed: int,
    setting: Setting,
) -> NDArray[np.uint16]:
    parts = []
    for frames in batches(camera, shot):
        signal = simulate(camera, shot, rates, seed=seed, frames=frames, until=Quantity.DN)
        steps = np.rint(signal.numpy() / setting.step_dn)
        codes = np.clip(steps, 0, round(255 / setting.step_dn)).astype(np.uint16)
        if codes.ndim == 4:  # a plane for each colour, which panels are cut out of faster
            codes = np.ascontiguousarray(np.moveaxis(codes, -1, 0))
        parts.append(codes)
    return np.concatenate(parts, axis=-3)


def _lattices(
    codes: NDArray[np.uint16], camera: Camera, panel: Panel, channel: str
) -> list[NDArray[np.uint16]]:
    rows, columns = panel.window
    if codes.ndim == 4:
        return [codes["RGB".index(channel)][:, rows, columns]]
    sites = [(k // 2, k % 2) for k in range(4) if camera.cfa[k] == channel]
    area = codes[:, rows, columns]
    return [area[:, (i - panel.y) % 2 :: 2, (j - panel.x) % 2 :: 2] for i, j in sites]


def _sloped(
    rate: NDArray[np.float32], panels: Sequence[Panel], gradient: float
) -> NDArray[np.float32]:
    """Light whose slope within each panel, margin included, is `gradient` times the lamp's."""
    changed = rate.copy()
    width = rate.shape[1] // len(panels)
    for k, panel in enumerate(panels):
        own = rate[:, k * width : (k + 1) * width]
        even = rate[panel.window].mean(axis=(0, 1))
        changed[:, k * width : (k + 1) * width] = even + np.float32(gradient) * (own - even)
    return np.maximum(changed, 0.0)


def predicted(setting: Setting, seen: Mapping[str, Sequence[Seen]]) -> dict[str, list[Seen]]:
    """What closed form predicts of panels that were measured, each at its measured level.

    Args:
        setting: the camera and how it was measured.
        seen: the panels in DN, by channel.

    Returns:
        the prediction for each of these panels in DN, by channel, in their order.
    """
    camera, step = setting.made(), setting.step_dn
    dark = camera.get(DarkShot)
    went_in = truth(setting)
    result = {}
    for channel, own in seen.items():
        make = Make(
            channel=channel,
            gain=camera.gain_dn_per_e[channel] / step,
            read=went_in[channel]["read"] / step,
            fpn=went_in[channel]["fpn"] / step,
            prnu=went_in[channel]["prnu_slope"],
            black=camera.black_dn / step,
            dark_e_per_s=dark.current_e_per_s if dark else 0.0,
            demosaiced=setting.demosaic,
            top=round(255 / step),
        )
        result[channel] = [
            predict(
                make,
                shot=s.shot,
                light_dn=0.0 if s.dark else s.mean_dn - make.black,
                exposure_s=s.exposure_s,
                frames=s.frames,
                size_px=s.rows,
                gradient=setting.gradient > 0,
            )
            for s in own
        ]
    return result


def estimate(
    setting: Setting, seen: Mapping[str, Sequence[Seen]], technique: Technique = PRINTED
) -> dict[str, dict[str, float]]:
    """The technique's parameters by channel, in DN."""
    black = setting.made().black_dn / setting.step_dn
    result = {}
    for channel, own in seen.items():
        found = parameters(
            own, channel, demosaiced=setting.demosaic, black_dn=black, technique=technique
        )
        result[channel] = {k: found[k] * setting.step_dn ** POWER_OF_STEP.get(k, 1.0) for k in KEYS}
    return result


def run_cell(
    setting: Setting, seeds: Sequence[int], techniques: Mapping[str, Technique]
) -> dict[str, Any]:
    """One cell: bias of every parameter by technique and channel, and its closed form.

    Returns:
        ``{"truth", "techniques": {name: {channel: {key: {"bias", "se", "expected"}}}}}``, the bias
        of each body kept too, under "each", so that cells of the same bodies can be compared.
    """
    went_in = truth(setting)
    bodies = [measure(setting, seed) for seed in seeds]
    ahead = predicted(setting, bodies[0])
    answer: dict[str, Any] = {}
    for name, technique in techniques.items():
        found = [estimate(setting, seen, technique) for seen in bodies]
        foretold = estimate(setting, ahead, technique)
        answer[name] = {
            channel: {
                key: _bias(
                    [f[channel][key] for f in found], foretold[channel][key], went_in[channel][key]
                )
                for key in KEYS
            }
            for channel in CHANNELS
        }
    return {"setting": dataclasses.asdict(setting), "truth": went_in, "techniques": answer}


def _bias(values: Sequence[float], expected: float, true: float) -> dict[str, Any]:
    error = np.array(values) - true
    se = float(error.std(ddof=1) / math.sqrt(error.size)) if error.size > 1 else math.inf
    return {
        "bias": float(error.mean()),
        "se": se,
        "expected": expected - true,
        "each": error.tolist(),
    }
