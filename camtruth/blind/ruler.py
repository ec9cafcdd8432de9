"""How severe an effect is, in detection limits, told without any diagnosis.

A diagnosis must not grade its own examination, so this is a battery of plain figures of its own:
block means, variances, neighbours, rows and columns, codes. The effect's signature s is by how much
it moves them (same random numbers, with and without it); what a small change of the base camera,
of the lamps and of a scene that is not quite as it was measured can imitate is projected out. Along
w = s / sd^2 nulls of other bodies scatter with
the standard deviation sigma, whatever the figures' correlations are, so the best a linear test of
known direction can do is

    z = w . s' / sigma,

with s' the signature in other random numbers, which makes z unbiased. What is another pattern in
every body (dust, steps of a converter) has no such direction: s and s' have nothing in common, and
the test that is left is that of the sum of squares, which is never better than that of a known
direction,

    z = min(|s|, |s|^2 / sd of |null|^2).

Severity is the larger z / 5: an effect at its detection limit stands 5 standard errors from zero.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.blind.unsure import Rates, unsure
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.dark_shot import DarkShot
from sensor.effects.fpn import Fpn
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.frames import Capture
from sensor.protocol import Protocol
from sensor.record import record

Floats = NDArray[np.float64]

LIMIT_Z = 5.0
NULLS = 12
GRID = (9, 12)
STEP = 0.05
"""Relative change of a base figure whose effect is projected out."""

MOST_FRAMES = 16
"""Frames of a shot that are looked at; severity grows as the root of their number."""


def battery(capture: Capture) -> Floats:
    """Some two hundred figures for each shot and colour, end to end."""
    parts = []
    for frames in capture.frames:
        stack = np.asarray(frames.dn[:MOST_FRAMES], dtype=np.float32)
        if frames.demosaiced:
            planes = [stack[..., k] for k in range(3)]
        elif frames.pixels.startswith("mono"):
            planes = [stack]
        else:
            planes = [stack[:, i::2, j::2] for i in (0, 1) for j in (0, 1)]
        residuals = []
        for plane in planes:
            figures, residual = _of_plane(plane, frames.top_dn)
            parts.append(figures)
            residuals.append(residual)
        for k in range(1, len(residuals)):
            a, b = residuals[k - 1], residuals[k]
            spread = float(a.std() * b.std()) or 1.0
            parts.append(np.array([float((a * b).mean()) / spread]))
    return np.concatenate(parts)


def _of_plane(plane: NDArray[np.float32], top_dn: int) -> tuple[Floats, NDArray[np.float32]]:
    mean = plane.mean(axis=0)
    r = plane - mean
    variance = r.var(axis=0)
    power = float(variance.mean()) or 1e-6
    pattern = mean[1:-1, 1:-1] - 0.25 * (mean[:-2, 1:-1] + mean[2:, 1:-1] + mean[1:-1, :-2]
                                         + mean[1:-1, 2:])  # fmt: skip
    codes = np.bincount(plane.astype(np.intp).ravel(), minlength=top_dn + 1)
    lags = [
        float((r[:, di:, dj:] * r[:, : r.shape[1] - di, : r.shape[2] - dj]).mean()) / power
        for di, dj in ((0, 1), (1, 0), (1, 1), (0, 2), (2, 0))
    ]
    figures = [
        np.log(power + 0.05),
        float(np.log(r.mean(axis=2).var() + 1e-4)),
        float(np.log(r.mean(axis=1).var() + 1e-4)),
        float(np.log(r.mean(axis=(1, 2)).var() + 1e-6)),
        *lags,
        float((r[1:] * r[:-1]).mean()) / power,
        float(np.log1p((r**4).mean() / power**2)),
        float(np.log(variance.max() + 0.05)),
        float(np.log(pattern.var() + 1e-3)),
        float(np.log1p((pattern**4).mean() / (pattern.var() ** 2 + 1e-6))),
        float(np.log(mean.mean(axis=1)[1:].var() + 1e-4)),
        float(np.log(np.diff(mean.mean(axis=0)).var() + 1e-4)),
        float(np.log(np.diff(mean.mean(axis=1)).var() + 1e-4)),
        float(np.sqrt(codes[0] / plane.size)),
        float(np.sqrt(codes[top_dn] / plane.size)),
        float(codes[1::2].sum() / plane.size),
        float(np.abs(np.diff(codes)).sum() / plane.size),
    ]
    return np.concatenate([figures, _blocks(mean), np.log(_blocks(variance) + 0.05)]), r


def _blocks(image: NDArray[np.float32]) -> Floats:
    rows = [part.mean(axis=0) for part in np.array_split(image, GRID[0], axis=0)]
    cells = [part.mean() for row in rows for part in np.array_split(row, GRID[1])]
    return np.array(cells, dtype=np.float64)


@dataclass(frozen=True, kw_only=True, eq=False)
class Ruler:
    """What is needed to tell severities in captures of one kind of camera.

    Attributes:
        sd: standard deviation of each figure between bodies.
        known: directions that calibration takes up, orthonormal rows, in units of `sd`.
        nulls: what bodies differ by besides, in units of `sd`, one row each.
    """

    sd: Floats
    known: Floats
    nulls: Floats

    def turned(self, difference: Floats) -> Floats:
        """A difference of figures in standard deviations, without what calibration takes up."""
        scaled = difference / self.sd
        return np.asarray(scaled - self.known.T @ (self.known @ scaled))

    def severity(self, first: Floats, second: Floats) -> float:
        """In detection limits, from the signature in two sets of random numbers."""
        w, s = self.turned(first), self.turned(second)
        if not np.any(w):
            return 0.0
        scatter = float(np.sqrt(np.mean((self.nulls @ w) ** 2)))
        along = float(w @ s) / (scatter or 1.0)
        square = 0.5 * float(w @ w + s @ s)
        of_nulls = float(np.square(self.nulls).sum(axis=1).std(ddof=1))
        size = min(np.sqrt(square), square / (of_nulls or 1.0))
        return max(along, float(size)) / LIMIT_Z

    def absorbed(self, signature: Floats) -> float:
        """Part of a signature that calibration takes up."""
        whole = float(np.sum((signature / self.sd) ** 2))
        return 1 - float(np.sum(self.turned(signature) ** 2)) / whole if whole > 0 else 1.0


def make_ruler(
    camera: Camera,
    protocol: Protocol,
    rates: Rates,
    seed: int,
    *,
    nulls: int = NULLS,
) -> Ruler:
    """A ruler for cameras like this one; some hundred and twenty captures.

    Args:
        camera: a typical one.
        protocol: the shots.
        rates: photo-electrons per second by lamp.
        seed: of the bodies.
        nulls: bodies that tell the scatter.
    """

    def seen(body: Camera, light: Rates, number: int) -> Floats:
        return battery(record(body.with_body(seed + number), protocol, light, seed=seed + number))

    bodies = np.array([seen(camera, rates, k) for k in range(nulls)])
    # few bodies tell each spread badly: neighbours in the battery share theirs
    sd = np.sqrt(bodies.var(axis=0, ddof=1) + 1e-12)
    sd = np.maximum(sd, 0.3 * np.median(sd))
    moved = [(seen(b, light, 0) - bodies[0]) / sd for b, light in nudged(camera, rates)]
    known = np.linalg.qr(np.array(moved).T)[0].T
    ruler = Ruler(sd=sd, known=known, nulls=np.zeros((0, sd.size)))
    rest = np.array([ruler.turned(b - bodies.mean(axis=0)) for b in bodies])
    return Ruler(sd=sd, known=known, nulls=rest * np.sqrt(nulls / (nulls - 1)))


def nudged(camera: Camera, rates: Rates) -> list[tuple[Camera, Rates]]:
    """The camera with each base figure a little off, and the light with what nobody knows of it."""
    one = 1 + STEP
    out: list[tuple[Camera, Rates]] = []
    for channel in "RGB":
        gains = camera.gain_dn_per_e.plain()
        gains = gains if isinstance(gains, dict) else dict.fromkeys("RGB", gains)
        changed = Colours(**{**gains, channel: gains[channel] * one})
        out.append((dataclasses.replace(camera, gain_dn_per_e=changed), rates))
    out.append((dataclasses.replace(camera, black_dn=camera.black_dn + 0.1), rates))
    for kind in (Prnu, Fpn, ReadNoise, DarkShot):
        effect = camera.get(kind)
        if effect is not None:
            out.append((camera.plus(scaled_figures(effect, one, 1.0)), rates))
    for lamp in rates:
        for k in range(3):
            gel = np.ones(3, dtype=np.float32)
            gel[k] = one
            out.append((camera, {**rates, lamp: rates[lamp] * gel}))
    out += [(camera, light) for light in unsure(rates, STEP)]
    return out


def scaled_figures(effect: Effect, factor: float, least: float) -> Effect:
    """A base effect with every figure multiplied; one that is 0 becomes `least`."""
    figures: dict[str, Any] = {}
    for p in effect.parameters():
        value = Colours.of(getattr(effect, p.name)).map(lambda v: v * factor if v else least)
        figures[p.name] = value if p.per_colour else value.G
    return dataclasses.replace(effect, **figures)
