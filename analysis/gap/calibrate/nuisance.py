"""What calibration may take up: every direction in which the base camera or its light can move.

Two kinds of direction. Figures of the camera are moved in a twin with the same random numbers. The
light is moved on paper: shading, focus, place, and the reflectance of single panels. Some are free,
others have a prior, because nobody's scene is quite as it was measured.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.agreement import agreed
from analysis.gap.calibrate.darks import GATHERED_DN
from analysis.gap.calibrate.relit import lighting, relit
from analysis.gap.camera.base import Base
from analysis.gap.camera.handles import Handle, handles_of, moved, step_of
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_ways import FREE, light_ways
from analysis.gap.camera.twin import Scenery, begun_twin, exposure_of
from analysis.gap.look.observation import Observation
from foundation.cores import ahead
from sensor.effect import Effect

Floats = NDArray[np.float64]


BLACK_STEPS_DN = (0.05, 0.3)
"""Least and largest step of the black level. By a step s a part s of the pixels change their code,
with a relative noise of sqrt((1 - s) / (s pixels)): a shorter one hardly leads along it. One that
is long beside the noise ends in another phase of the rounding."""

BLUR_STEP_PX2 = 0.2
"""Step of the variance of the blur without blur; a tenth of what there is is added."""

UNEVEN_STEP = 0.3
"""Step of the law of dark currents: a skewness of 0.9."""

PART_OF_HIDDEN = 0.6
"""Step of a pattern's variance, as a part of the noise in time of one frame."""


@dataclass(frozen=True, kw_only=True)
class Knob:
    """A figure of the base that calibration turns.

    Attributes:
        name: as `Base.moved` takes it.
        channel: index, or None.
        step: of the difference quotient.
        width: by which it may be expected to move; infinite where nothing tells it beforehand.
    """

    name: str
    channel: int | None
    step: float
    width: float = FREE


@dataclass(frozen=True, kw_only=True, eq=False)
class Directions:
    """Directions as differences of figures and block means, before any units.

    Attributes:
        knobs: figures of the camera; they come first.
        tuned: parameters of the effects that the camera has; they come next, so that what is left
            is not what a better fit of these would take up.
        figures: (directions, figures).
        means: (directions, shots, channels, blocks).
        prior: standard deviation of each; infinite where free.
    """

    knobs: tuple[Knob, ...]
    tuned: tuple[Handle, ...]
    figures: Floats
    means: Floats
    prior: Floats


def knobs_of(base: Base, scenery: Scenery) -> tuple[Knob, ...]:
    """Which figures can be calibrated with these shots, and by which step."""
    lit = any(not shot.dark for shot in scenery.shots)
    exposures = {shot.exposure_s for shot in scenery.shots}
    longest = max(exposures)
    # what noise in time leaves in the mean of a group hides the pattern: a step has to be seen
    hidden = PART_OF_HIDDEN / scenery.view.frames
    bright_dn = brightest_dn(base, scenery)
    black_dn = float(np.clip(np.min(base.read_dn2), *BLACK_STEPS_DN))
    # darks tell gains of colours over that of green, by what gathers in all of them alike
    gathers = base.shown_e_per_s * longest * float(base.gain_dn_per_e.min()) >= GATHERED_DN
    knobs = []
    for c in range(len(base.channels)):
        read = float(base.read_dn2[c])
        knobs.append(Knob(name="read", channel=c, step=0.3 * read + 0.003))
        fpn = 0.6 * float(base.fpn_dn2[c]) + hidden * read + 1e-3
        knobs.append(Knob(name="fpn", channel=c, step=fpn))
        knobs.append(Knob(name="black", channel=c, step=black_dn))
        if lit or (gathers and base.channels[c] in ("R", "B")):
            knobs.append(Knob(name="gain", channel=c, step=0.15))
        if lit:
            noise = read + float(base.gain_dn_per_e[c]) * bright_dn
            prnu = 1.5 * float(base.prnu2[c]) + hidden * noise / bright_dn**2 + 5e-6
            knobs.append(Knob(name="prnu", channel=c, step=prnu))
            if scenery.light.known:
                knobs += [
                    Knob(name=f"level:{lamp}", channel=c, step=0.02)
                    for lamp in sorted({lamp_of(s) for s in scenery.shots if not s.dark})
                ]
    if len(exposures) > 1 or lit:
        # small beside the noise of every channel: their gains may differ several times
        charge = 0.3 * float(np.min(base.read_dn2 / base.gain_dn_per_e**2)) + 0.5
        knobs.append(Knob(name="dark", channel=None, step=charge / longest))
    # a surface through the frames is as soft as any
    if lit and scenery.light.known and not scenery.light.drawn:
        knobs.append(Knob(name="blur", channel=None, step=BLUR_STEP_PX2 + 0.1 * base.blur_px2))
    if len(exposures) > 1:
        shown = black_dn / float(base.gain_dn_per_e.max())
        knobs.append(Knob(name="shown", channel=None, step=shown / longest))
    if base.dark_spread2 > 0:
        # as for the fixed offsets, in electrons of the channel that shows it best
        noise_e2 = float(np.min(base.read_dn2 / base.gain_dn_per_e**2)) + 1.0
        spread = 0.6 * base.dark_spread2 + hidden * noise_e2 / longest**2
        knobs.append(Knob(name="spread", channel=None, step=spread))
        knobs.append(Knob(name="uneven", channel=None, step=UNEVEN_STEP))
    if base.clamp_e2 > 0:
        # few frames tell it, by their means: moments do so better than a step that is lost in noise
        known = 0.5 * base.clamp_e2
        knobs.append(Knob(name="clamp", channel=None, step=0.6 * base.clamp_e2, width=known))
    return tuple(knobs)


def brightest_dn(base: Base, scenery: Scenery) -> float:
    """Mean above black of the brightest shot and channel; 1 of darks."""
    signals = [
        exposure_of(shot)
        * base.gain_dn_per_e
        * base.level[lamp_of(shot)]
        * np.mean(scenery.light.rates[lamp_of(shot)])
        for shot in scenery.shots
        if not shot.dark and lamp_of(shot) in scenery.light.rates
    ]
    return max(float(np.max(signals, initial=1.0)), 1.0)


Twins = tuple[Observation, ...]
"""One for each set of random numbers."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moved:
    """Twins of a model, and of the model with one thing moved, with the same random numbers.

    Attributes:
        references: of the model, one for each set of random numbers.
        knobs: of the model with a knob turned in all channels, by name of the knob.
        parameters: of the model with a parameter of an effect moved, in all channels.
        steps: by how much the parameters were moved, by handle of each channel.
    """

    references: Twins
    knobs: dict[str, Twins]
    parameters: dict[Handle, Twins]
    steps: dict[Handle, float]

    def seen_by(self, look: Callable[[Observation], Observation]) -> Moved:
        """These twins, each as `look` sees it, with the same steps."""

        def all_of(twins: Twins) -> Twins:
            return tuple(look(one) for one in twins)

        return Moved(
            references=all_of(self.references),
            knobs={name: all_of(twins) for name, twins in self.knobs.items()},
            parameters={name: all_of(twins) for name, twins in self.parameters.items()},
            steps=self.steps,
        )


def moved_twins(
    base: Base,
    scenery: Scenery,
    references: Mapping[int, Observation],
    effects: Sequence[Effect] = (),
) -> Moved:
    """Twins from which directions are read.

    Args:
        base: the calibrated camera.
        scenery: light and shots.
        references: twins of the camera by the seed of their random numbers.
        effects: what the camera has besides.
    """

    def seen_with(cameras: Iterable[tuple[Base, Scenery, Sequence[Effect]]]) -> Iterator[Twins]:
        """Twins of cameras under lights with effects, all sets of random numbers for each."""
        seen = ahead(
            begun_twin(light, camera, effects=has, seed=seed)
            for camera, light, has in cameras
            for seed in references
        )
        return zip(*[iter(list(seen))] * len(references), strict=True)

    cameras: dict[str, Base] = {}
    for knob in knobs_of(base, scenery):
        # channels have nothing to do with each other, so all are moved at once and told apart
        camera = cameras.get(knob.name, base)
        cameras[knob.name] = camera.moved(knob.name, knob.channel, knob.step)
    turned = seen_with((camera, scenery, effects) for camera in cameras.values())
    first = next(iter(references))
    how = lighting(base, scenery, references[first]) if effects else None
    others: dict[Handle, tuple[Base, Scenery, Sequence[Effect]]] = {}
    steps: dict[Handle, float] = {}
    for k, effect in enumerate(effects):
        for p in effect.parameters():
            handles = handles_of(effect, p, base.channels)
            if not handles:
                continue
            moves = {h: step_of(effect, p, h.channel) for h in handles}
            steps |= moves
            after = [*effects[:k], moved(effect, moves), *effects[k + 1 :]]
            lit = relit(how, base, scenery, before=effects, after=after, seed=first)
            others[Handle(effect=effect.name, parameter=p.name)] = *lit, after
    return Moved(
        references=tuple(references.values()),
        knobs=dict(zip(cameras, turned, strict=True)),
        parameters=dict(zip(others, seen_with(others.values()), strict=True)),
        steps=steps,
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
    changed = {whole: agreed(moved.references, after) for whole, after in moved.parameters.items()}
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
        prior.append(knob.width)
    for handle, step in moved.steps.items():
        whole = dataclasses.replace(handle, channel=None)
        of_figures, of_means = changed[whole]
        own, only = np.ones(len(reference.keys)), np.ones(len(base.channels))
        if handle.channel is not None:
            own = _own(reference, base, handle.channel)
            only = np.eye(len(base.channels))[handle.channel]
        figures.append(of_figures / step * own)
        means.append(of_means / step * only[:, None])
        prior.append(5.0 * abs(step))
    light = of_the_light(base, scenery, reference)
    return Directions(
        knobs=knobs,
        tuned=tuple(moved.steps),
        figures=np.concatenate([figures, light.figures]),
        means=np.concatenate([means, light.means]),
        prior=np.concatenate([prior, light.prior]),
    )


def of_the_light(base: Base, scenery: Scenery, reference: Observation) -> Directions:
    """Directions of the light alone.

    Args:
        base: the calibrated camera.
        scenery: light and shots.
        reference: a twin of the camera.
    """
    ways = list(light_ways(base, scenery, reference))
    return Directions(
        knobs=(),
        tuned=(),
        figures=np.zeros((len(ways), len(reference.keys))),
        means=np.array([way.means for way in ways]).reshape(-1, *reference.means.shape[1:]),
        prior=np.array([way.prior for way in ways]),
    )


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
