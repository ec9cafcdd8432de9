"""What calibration may take up: every direction in which the base camera or its light can move.

Two kinds of direction. Figures of the camera are moved in a twin with the same random numbers. The
light is moved on paper: shading, focus, place, and the reflectance of single panels. Some are free,
others have a prior, because nobody's scene is quite as it was measured.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.base import Base
from analysis.gap.light import lamp_of
from analysis.gap.light_blocks import blocks_of
from analysis.gap.observe import Key, Observation
from analysis.gap.space import Space
from analysis.gap.twin import Scenery, exposure_of, twin
from sensor.effect import Effect, Parameter

Floats = NDArray[np.float64]

SHADING_PRIOR = 0.01
PANEL_PRIOR = 0.01
LEVEL_PRIOR = 0.001
"""Of a shot's level against what the manifest states."""

FREE = np.inf

BLACK_STEP_DN = 0.05
BLUR_STEP_PX2 = 0.2

COHERENT = 0.2
"""Correlation from which two images show the same thing."""


@dataclass(frozen=True, kw_only=True)
class Knob:
    """A figure of the base that calibration turns.

    Attributes:
        name: as `Base.moved` takes it.
        channel: index, or None.
        step: of the difference quotient.
    """

    name: str
    channel: int | None
    step: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Directions:
    """Directions as differences of figures and block means, before any units.

    Attributes:
        knobs: figures of the camera; they come first.
        tuned: parameters of the effects that the camera has, by name of effect and parameter; they
            come next, so that what is left is not what a better fit of these would take up.
        figures: (directions, figures).
        means: (directions, shots, channels, blocks).
        prior: standard deviation of each; infinite where free.
    """

    knobs: tuple[Knob, ...]
    tuned: tuple[tuple[str, str], ...]
    figures: Floats
    means: Floats
    prior: Floats


def knobs_of(base: Base, scenery: Scenery) -> tuple[Knob, ...]:
    """Which figures can be calibrated with these shots, and by which step."""
    lit = any(not shot.dark for shot in scenery.shots)
    exposures = {shot.exposure_s for shot in scenery.shots}
    longest = max(exposures)
    knobs = []
    for c in range(len(base.channels)):
        knobs.append(Knob(name="read", channel=c, step=0.3 * float(base.read_dn2[c]) + 0.003))
        knobs.append(Knob(name="fpn", channel=c, step=0.6 * float(base.fpn_dn2[c]) + 1e-3))
        knobs.append(Knob(name="black", channel=c, step=BLACK_STEP_DN))
        if lit:
            knobs.append(Knob(name="gain", channel=c, step=0.15))
            knobs.append(Knob(name="prnu", channel=c, step=0.6 * float(base.prnu2[c]) + 5e-6))
            knobs += [
                Knob(name=f"level:{lamp}", channel=c, step=0.02)
                for lamp in sorted({lamp_of(s) for s in scenery.shots if not s.dark})
            ]
    if len(exposures) > 1 or lit:
        charge = 0.3 * float(np.mean(base.read_dn2 / base.gain_dn_per_e**2)) + 0.5
        knobs.append(Knob(name="dark", channel=None, step=charge / longest))
    if lit and scenery.light.known:
        knobs.append(Knob(name="blur", channel=None, step=BLUR_STEP_PX2 + 0.1 * base.blur_px2))
    if len(exposures) > 1:
        shown = BLACK_STEP_DN / float(base.gain_dn_per_e.mean())
        knobs.append(Knob(name="shown", channel=None, step=shown / longest))
    return tuple(knobs)


@dataclass(frozen=True, kw_only=True, eq=False)
class Moved:
    """Twins of a model, and of the model with one thing moved, with the same random numbers.

    Attributes:
        references: of the model, one for each set of random numbers.
        knobs: of the model with a knob turned in all channels, by name of the knob.
        parameters: of the model with a parameter of an effect moved, by effect and parameter.
        steps: by how much the parameters were moved.
    """

    references: tuple[Observation, ...]
    knobs: dict[str, tuple[Observation, ...]]
    parameters: dict[tuple[str, str], tuple[Observation, ...]]
    steps: dict[tuple[str, str], float]

    def seen_by(self, look: Callable[[Observation], Observation]) -> Moved:
        """The same twins, looked at in another way."""

        def all_of(twins: tuple[Observation, ...]) -> tuple[Observation, ...]:
            return tuple(look(one) for one in twins)

        return Moved(
            references=all_of(self.references),
            knobs={name: all_of(twins) for name, twins in self.knobs.items()},
            parameters={name: all_of(twins) for name, twins in self.parameters.items()},
            steps=self.steps,
        )


def moved_twins(
    base: Base, scenery: Scenery, seeds: Sequence[int], effects: Sequence[Effect] = ()
) -> Moved:
    """Twins from which directions are read.

    Args:
        base: the calibrated camera.
        scenery: light and shots.
        seeds: random numbers, once each.
        effects: what the camera has besides.
    """

    def twins(camera: Base, has: Sequence[Effect]) -> tuple[Observation, ...]:
        return tuple(twin(scenery, camera, effects=has, seed=seed) for seed in seeds)

    knobs = knobs_of(base, scenery)
    by_knob = {}
    for name in dict.fromkeys(knob.name for knob in knobs):
        # channels have nothing to do with each other, so all are moved at once and told apart
        camera = base
        for knob in knobs:
            if knob.name == name:
                camera = camera.moved(knob.name, knob.channel, knob.step)
        by_knob[name] = twins(camera, effects)
    by_parameter, steps = {}, {}
    for k, effect in enumerate(effects):
        for p in free_parameters(effect):
            by = step_of(effect, p)
            other = dataclasses.replace(effect, **{p.name: getattr(effect, p.name) + by})
            key = (effect.name, p.name)
            steps[key] = by
            by_parameter[key] = twins(base, [*effects[:k], other, *effects[k + 1 :]])
    return Moved(
        references=twins(base, effects), knobs=by_knob, parameters=by_parameter, steps=steps
    )


def directions(base: Base, scenery: Scenery, moved: Moved) -> Directions:
    """All directions at a model.

    Args:
        base: the calibrated camera.
        scenery: light and shots.
        moved: its twins; see `moved_twins`.
    """
    knobs = knobs_of(base, scenery)
    reference = moved.references[0]
    changes = {name: agreed(moved.references, after) for name, after in moved.knobs.items()}
    figures, means, prior = [], [], []
    for knob in knobs:
        of_figures, of_means = changes[knob.name]
        channel = np.ones(len(base.channels))
        if knob.channel is not None:
            channel = np.eye(len(base.channels))[knob.channel]
        lamp = np.ones(len(scenery.shots))
        if knob.name.startswith("level:"):
            lamp = _shots_of(knob, scenery)
        own = _own(reference, base, knob.channel)
        figures.append(of_figures / knob.step * own)
        means.append(of_means / knob.step * lamp[:, None, None] * channel[:, None])
        prior.append(FREE)
    for key, after in moved.parameters.items():
        of_figures, of_means = agreed(moved.references, after)
        figures.append(of_figures / moved.steps[key])
        means.append(of_means / moved.steps[key])
        prior.append(5.0 * abs(moved.steps[key]))
    for change, width in _of_light(base, scenery, reference):
        means.append(change)
        figures.append(np.zeros(len(reference.keys)))
        prior.append(width)
    return Directions(
        knobs=knobs,
        tuned=tuple(moved.parameters),
        figures=np.array(figures),
        means=np.array(means),
        prior=np.array(prior),
    )


def free_parameters(effect: Effect) -> list[Parameter]:
    """The parameters of an effect that can be fitted: strengths that are on, and shapes."""
    return [
        p
        for p in effect.parameters()
        if not p.whole
        and isinstance(getattr(effect, p.name), float)
        and not (p.identity is not None and getattr(effect, p.name) == p.identity)
    ]


def step_of(effect: Effect, p: Parameter) -> float:
    """Step of a parameter's difference quotient: a tenth of it, or a hundredth of its range."""
    value = float(getattr(effect, p.name))
    size = abs(value - p.identity) if p.identity is not None and p.identity < 1e6 else abs(value)
    step = 0.1 * (size or 0.1 * (p.maximum - p.minimum))
    return step if value + step <= p.maximum else -step


def agreed(before: Sequence[Observation], after: Sequence[Observation]) -> tuple[Floats, Floats]:
    """What a change does to figures and block means, as far as all random numbers agree on it.

    Differences of twins with the same random numbers still have noise, from rounding above all, and
    a thousand small errors of a direction are as bad as one large error: they would make it longer,
    and whatever is measured along it too small. The mean m of a figure with standard error e is
    drawn to zero by 1 - (e / m)^2, and once more by what all figures of one kind together have of
    that ratio: a kind of figure that does not move says so by its many members.
    """
    pairs = list(zip(before, after, strict=True))
    figures = np.array([(b.figures - a.figures).mean(axis=0) for a, b in pairs])
    means = np.array([(b.means - a.means).mean(axis=0) for a, b in pairs])
    if len(pairs) == 1:
        return figures[0], means[0]
    mean, square = figures.mean(axis=0), figures.var(axis=0, ddof=1) / len(pairs)
    drawn = np.zeros_like(mean)
    for places in _alike(before[0].keys):
        own, noise = mean[places], square[places]
        noise = (noise + BORROWED * noise.mean()) / (1 + BORROWED)
        ratio = np.square(own) / np.maximum(noise, 1e-300)
        of_kind = max(0.0, 1.0 - 1.0 / max(float(ratio.mean()), 1e-300))
        drawn[places] = own * of_kind * np.maximum(0.0, 1.0 - 1.0 / np.maximum(ratio, 1e-300))
    return drawn, _coherent(means)


BORROWED = 3.0
"""Weight of the others of its kind in the noise of a figure's change, against its own."""


@functools.lru_cache(maxsize=8)
def _alike(keys: tuple[Key, ...]) -> list[NDArray[np.intp]]:
    """Places of the figures of each kind: one statistic, in all shots and lattices."""
    kinds: dict[tuple[str, str], list[int]] = {}
    for place, key in enumerate(keys):
        kinds.setdefault((key.family, key.statistic), []).append(place)
    return [np.array(places) for places in kinds.values()]


def _coherent(images: Floats) -> Floats:
    """Mean of images that show the same thing; nothing, where each shows another.

    A pattern that belongs to a camera body is in another place in every body: no template of the
    mean image, though figures of its size are.
    """
    mean = images.mean(axis=0)
    total = float(np.square(images).sum())
    if len(images) == 1 or total == 0:
        return np.asarray(mean)
    alike = (len(images) * float(np.square(mean).sum()) - total / len(images)) / total
    return np.asarray(mean) if alike > COHERENT * (1 - 1 / len(images)) else np.zeros_like(mean)


def _own(reference: Observation, base: Base, channel: int | None) -> Floats:
    """Part of a figure's change that belongs to a channel: all of its own lattices, its share of
    the figures that look at all.
    """
    if channel is None:
        return np.ones(len(reference.keys))
    share = 1.0 / len(base.channels)
    letter = base.channels[channel]

    def part(lattice: str, statistic: str) -> float:
        if lattice != "all":
            return float(lattice.startswith(letter))
        named = [c for c in base.channels if c in statistic.split()]
        return (letter in named) / len(named) if named else share

    return np.array([part(key.lattice, key.statistic) for key in reference.keys])


def _shots_of(knob: Knob, scenery: Scenery) -> Floats:
    lamp = knob.name.removeprefix("level:")
    return np.array([float(not s.dark and lamp_of(s) == lamp) for s in scenery.shots])


def _of_light(
    base: Base, scenery: Scenery, reference: Observation
) -> Iterator[tuple[Floats, float]]:
    """Changes of the block means by the light alone, each with its prior."""
    shape = reference.means.shape[1:]
    lit = [k for k, shot in enumerate(scenery.shots) if not shot.dark]
    lamps = sorted({lamp_of(scenery.shots[k]) for k in lit})
    unit = {
        lamp: (base.level[lamp] * base.gain_dn_per_e)[:, None]
        * blocks_of(scenery.light.rates[lamp], scenery.view, base.channels)
        for lamp in lamps
    }
    for k in lit:
        change = np.zeros(shape)
        shot = scenery.shots[k]
        change[k] = unit[lamp_of(shot)] * exposure_of(shot)
        yield change, LEVEL_PRIOR
    if not scenery.light.known:
        return

    def everywhere(by_lamp: dict[str, Floats]) -> Floats:
        change = np.zeros(shape)
        for k in lit:
            shot = scenery.shots[k]
            if lamp_of(shot) in by_lamp:
                change[k] = by_lamp[lamp_of(shot)] * exposure_of(shot)
        return change

    down, across = reference.grid
    y = np.repeat(np.linspace(-1, 1, down), across)
    x = np.tile(np.linspace(-1, 1, across), down)
    for shading in (x, y, x * x, x * y, y * y):
        for lamp in lamps:
            yield everywhere({lamp: unit[lamp] * shading}), SHADING_PRIOR
    yield from ((everywhere(change), FREE) for change in _moved(base, scenery, lamps))
    height, width = scenery.body.height, scenery.body.width
    for panel in scenery.light.panels:
        mask = np.zeros((height, width, 3), dtype=np.float32)
        mask[panel.y : panel.y + panel.h, panel.x : panel.x + panel.w] = 1.0
        where = blocks_of(mask, scenery.view, base.channels)
        for c in range(len(base.channels)):
            one = np.zeros_like(where)
            one[c] = where[c]
            yield everywhere({lamp: unit[lamp] * one for lamp in lamps}), PANEL_PRIOR


def _moved(base: Base, scenery: Scenery, lamps: list[str]) -> Iterator[dict[str, Floats]]:
    """The picture shifted, turned and scaled, by lamp."""
    pieces: list[dict[str, Floats]] = [{} for _ in range(4)]
    for lamp in lamps:
        rate = scenery.light.rates[lamp].astype(np.float32)
        dy, dx = np.gradient(rate, axis=(0, 1))
        h, w = rate.shape[:2]
        y = (np.arange(h, dtype=np.float32) - h / 2)[:, None, None] / w
        x = (np.arange(w, dtype=np.float32) - w / 2)[None, :, None] / w
        scale = (base.level[lamp] * base.gain_dn_per_e)[:, None]
        for piece, image in zip(pieces, (dx, dy, x * dx + y * dy, x * dy - y * dx), strict=True):
            piece[lamp] = scale * blocks_of(image, scenery.view, base.channels)
    yield from pieces


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """A space less what calibration takes up.

    Attributes:
        space: where figures have units of their standard errors.
        q: orthonormal columns over the coordinates and the priors, (coordinates + n, n).
        solve: from projections to amounts of each direction.
    """

    space: Space
    q: Floats
    solve: Floats

    def left(self, vector: Floats) -> Floats:
        """What calibration cannot take up of a vector, or of several (rows)."""
        n = self.q.shape[0] - vector.shape[-1]
        padded = np.concatenate([vector, np.zeros((*vector.shape[:-1], n))], axis=-1)
        return np.asarray(padded - (padded @ self.q) @ self.q.T)

    def amounts(self, vector: Floats) -> Floats:
        """How much of each direction calibration takes up."""
        return np.asarray(self.solve @ (self.q[: len(vector)].T @ vector))


def calibration(space: Space, ways: Directions) -> Calibration:
    """What is left of a space when all directions are taken out.

    A prior of standard deviation s is one more measurement: that the amount is 0 +- s.
    """
    columns = np.array(
        [space.vector(f, m) for f, m in zip(ways.figures, ways.means, strict=True)]
    ).T
    size = np.linalg.norm(columns, axis=0)
    with np.errstate(divide="ignore"):
        priors = np.where(np.isinf(ways.prior), 0.0, 1.0 / ways.prior)
    # a direction that shows nowhere is held where it is
    priors = np.where(size + priors < 1e-9, 1.0, priors)
    scale = np.hypot(size, priors)
    matrix = np.vstack([columns, np.diag(priors)]) / scale
    squares, v = np.linalg.eigh(matrix.T @ matrix)
    good = squares > 1e-10 * squares[-1]
    length = np.sqrt(squares[good])
    q = matrix @ (v[:, good] / length)
    return Calibration(space=space, q=q, solve=(v[:, good] / length) / scale[:, None])
