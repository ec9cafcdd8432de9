"""What each estimator must read out of a panel with a ramp, in closed form.

A site's code has the mean and the variance of rounded noise (`analysis.bias.rounding`) about the
site's own level, which the ramp carries over the codes. Over the panel a ramp that rises by g has
the variance g^2 / 12 along each axis; who does not take it off reads it as PRNU.

    in time   mean over sites of the variance of the codes, or of their SD
    in space  variance over sites of the codes' means: ramp, pattern and staircase together

The estimators' own arithmetic, biases included, then makes parameters of these. The corrected
estimator has no bias that we know of.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.bias.demosaic import detrended_variance
from analysis.bias.prediction import Seen
from analysis.bias.rounding import Floats, rounded, sample_sd_factor
from analysis.bias.technique import parameters
from analysis.estimators.emva1288 import HALF, LEAST_DARK_VARIANCE_DN2, REGRESSION
from analysis.estimators.parts.high_pass import spatial_variance
from analysis.estimators.parts.panel_noise import parabola_basis
from analysis.estimators.photon_transfer import line
from analysis.study.bench import EXPOSURE_S, FPN_DN8, PRNU, Bench
from sensor.protocol import Shot

COARSE, FINE = 41, 801
"""Places in a pattern: many for a dark panel, whose sites are all alike; fewer under a ramp, which
stirs by itself."""

REACH = 5.0
"""How far in a Gaussian pattern they go."""

LOUD_DN = 0.8
"""Noise from which rounding is 1/12 to 1 in 10^5 wherever the level lies."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One lattice of a channel in one shot: means of its codes (h, w) in DN, without pattern, and
    variances in DN^2: of the pattern as rounded, and in time; `sd_dn` is the mean SD in time."""

    image: Floats
    pattern: float
    temporal: float
    sd_dn: float


def predict(made: Bench, channel: str) -> dict[str, dict[str, float]]:
    """Parameters by method, as `analysis.parameters` names them; what has no closed form is out."""
    shots = made.protocol.shot
    parts = {shot.label: _parts(made, channel, shot) for shot in shots}
    truth = made.truth
    return {
        "irie": _irie(made, channel, parts),
        "photon_transfer": _photon_transfer(shots, parts),
        "emva1288": _emva1288(made, shots, parts),
        "corrected": {k: truth[k] for k in ("read", "gain", "fpn", "prnu")},
    }


def _parts(made: Bench, channel: str, shot: Shot) -> list[Part]:
    camera, panel = made.camera, made.panel
    gain, scale = camera.gain_dn_per_e[channel], 2.0 ** (camera.bits - 8)
    rate = 0.0 if shot.dark else made.rates[shot.light[0]][panel.window] * shot.level[0]
    plane = np.broadcast_to(np.asarray(rate, dtype=np.float64), (panel.h, panel.w, 3))
    light = plane[..., "RGB".index(channel)] * gain * EXPOSURE_S
    found = []
    for k in (k for k in range(4) if camera.cfa[k] == channel):
        i, j = (k // 2 - panel.y) % 2, (k % 2 - panel.x) % 2
        own = light[i::2, j::2]
        noise = np.sqrt(made.truth["read"] ** 2 + gain * own)
        pattern = np.hypot(FPN_DN8 * scale, PRNU * own)
        found.append(
            _part(camera.black_dn + own, noise, pattern, shot.frames, camera.format.top_dn)
        )
    return found


def _part(level: Floats, noise: Floats, pattern: Floats, frames: int, top: int) -> Part:
    if noise.min() > LOUD_DN:
        temporal = noise**2 + 1 / 12
        return Part(
            image=level,
            pattern=float(np.mean(pattern**2)),
            temporal=float(temporal.mean()),
            sd_dn=float(np.sqrt(temporal).mean()) * sample_sd_factor(frames),
        )
    alike = np.ptp(level) == 0
    nodes = np.linspace(-REACH, REACH, FINE if alike else COARSE)
    weight = np.exp(-0.5 * nodes**2)
    weight /= weight.sum()
    shape = level.shape
    if alike:
        level, noise, pattern = level[:1, :1], noise[:1, :1], pattern[:1, :1]
    y = rounded(level[..., None] + pattern[..., None] * nodes, noise[..., None], top)
    image = y.mean_dn @ weight
    return Part(
        image=np.broadcast_to(image, shape),
        pattern=float(np.mean(y.mean_dn**2 @ weight - image**2)),
        temporal=float(np.mean(y.sd_dn**2 @ weight)),
        sd_dn=float(np.mean(y.sample_sd_dn(frames) @ weight)),
    )


def _irie(made: Bench, channel: str, parts: dict[str, list[Part]]) -> dict[str, float]:
    seen = []
    for shot in made.protocol.shot:
        own = parts[shot.label]
        rows, columns = own[0].image.shape
        free = detrended_variance("G", rows, columns, demosaiced=False)
        left = [_detrended(part.image) for part in own]
        noise = [part.pattern + part.temporal / shot.frames for part in own]
        seen.append(
            Seen(
                shot=shot.label,
                dark=shot.dark,
                exposure_s=shot.exposure_s,
                frames=shot.frames,
                rows=rows,
                mean_dn=_mean([float(part.image.mean()) for part in own]),
                temporal_dn=_mean([part.sd_dn for part in own]),
                spatial_dn=math.sqrt(_mean(left) + free * _mean(noise)),
            )
        )
    return parameters(seen, channel, demosaiced=False)


def _detrended(image: Floats) -> float:
    down = parabola_basis(len(image))
    left = image - down @ (down.T @ image)
    return float(np.sum(left * left)) / (image.size - 1)


def _photon_transfer(shots: tuple[Shot, ...], parts: dict[str, list[Part]]) -> dict[str, float]:
    level = np.array([_mean([float(p.image.mean()) for p in parts[s.label]]) for s in shots])
    temporal = np.array([_mean([p.temporal for p in parts[s.label]]) for s in shots])
    spatial = np.array(
        [_mean([float(p.image.var()) + p.pattern for p in parts[s.label]]) for s in shots]
    )
    residual = temporal / np.array([s.frames for s in shots])
    dark = np.array([s.dark for s in shots])
    signal = np.where(dark, 0.0, level - level[dark].mean())
    read, gain = (v for v, _ in line(signal, temporal, temporal + 1e-6))
    fpn, prnu = (v for v, _ in line(signal**2, spatial, spatial + residual + 1e-6))
    found = {"gain": gain}
    for key, value in (("read", read), ("fpn", fpn), ("prnu", prnu)):
        if value > 0:
            found[key] = math.sqrt(value)
    return found


def _emva1288(
    made: Bench, shots: tuple[Shot, ...], parts: dict[str, list[Part]]
) -> dict[str, float]:
    top = made.camera.format.top_dn
    level = {s.label: _mean([float(p.image.mean()) for p in parts[s.label]]) for s in shots}
    temporal = {s.label: _mean([p.temporal for p in parts[s.label]]) for s in shots}
    spatial = {
        s.label: _mean([spatial_variance(p.image)[0] + p.pattern for p in parts[s.label]])
        for s in shots
    }
    (dark,) = (s.label for s in shots if s.dark)
    lit = [s.label for s in shots if not s.dark]
    room = top - level[dark]
    used = [k for k in lit if level[k] - level[dark] <= REGRESSION * room]
    x = np.array([level[k] - level[dark] for k in used])
    y = np.array([temporal[k] - temporal[dark] for k in used])
    found = {"gain": float(x @ y / (x @ x)), "fpn": math.sqrt(spatial[dark])}
    if temporal[dark] >= LEAST_DARK_VARIANCE_DN2:
        found["read"] = math.sqrt(temporal[dark] - 1 / 12)
    half = min(lit, key=lambda k: abs(level[k] - HALF * top))
    excess = spatial[half] - spatial[dark]
    if excess > 0:
        found["prnu"] = math.sqrt(excess) / (level[half] - level[dark])
    return found


def _mean(values: list[float]) -> float:
    return float(np.mean(values))
