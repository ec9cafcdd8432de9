"""The shots that separate most effects of the catalogue for the fewest frames."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from analysis.gap.calibrate.fit import around
from analysis.gap.look.shots import GROUP_FRAMES, KEY_SHOTS
from analysis.identifiability.known import base_of, scenery_of
from analysis.identifiability.shots import candidates, of_the_paper, with_uniform
from analysis.identifiability.subsets import Prediction, Separability, predict
from foundation.errors import InputError
from render.rate import RateImage
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.protocol import Protocol

GROUPS = (2, 3, 4, 6)
"""Groups of frames of each shot that are tried; a diagnosis looks at two to six."""

SEARCHED = 3
"""Groups with which shots are chosen; how many frames of each is asked afterwards."""

MOST_SHOTS = KEY_SHOTS
"""A diagnosis fits no more."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """A protocol on the way: its shots, frames of each, and how many effects it separates."""

    shots: tuple[str, ...]
    frames: int
    separated: int

    @property
    def total(self) -> int:
        """Frames of all shots together."""
        return len(self.shots) * self.frames


@dataclass(frozen=True, kw_only=True, eq=False)
class Recommendation:
    """The protocol, and what it tells.

    Attributes:
        protocol: ready to be captured.
        told: what it tells of each effect.
        front: protocols that no other one beats with as few frames, fewest frames first.
        reference: what the paper's protocol separates; None where the scene has not its lamps.
    """

    protocol: Protocol
    told: Separability
    front: tuple[Step, ...]
    reference: Step | None


def recommend(
    camera: Camera,
    light: Mapping[str, RateImage],
    *,
    strength: float,
    kinds: Iterable[type[Effect]] | None = None,
    most_frames: int | None = None,
    watch: Callable[[str], None] = lambda what: None,
) -> Recommendation:
    """Predict what shots tell, and choose.

    Args:
        camera: whose frames they will be; effects that it has besides the base count as known.
        light: rate images of the scene by lamp, on few pixels; see `small_light`.
        strength: of the effects, of their defaults.
        kinds: effects that are to be told apart; all of the catalogue by default.
        most_frames: of the whole protocol.

    Raises:
        InputError: for too few frames.
    """
    least = GROUPS[0] * GROUP_FRAMES
    if most_frames is not None and most_frames < least:
        raise InputError(
            f"{most_frames} frames in all",
            f"expected at least the {least} that one shot needs",
            "give more with --frames",
        )
    first = next(iter(light.values()))
    height, width = first.rate_e_per_s.shape[:2]
    rates = with_uniform({lamp: image.rate_e_per_s for lamp, image in light.items()})
    lamps = tuple(light)
    small = camera.resized(height, width)
    shots = candidates(lamps)
    scenery = scenery_of(small, shots, rates, first.header.panels)
    extra = tuple(effect for effect in camera.effects if not effect.base)
    watch("base camera")
    known = around(base_of(small, list(rates)), scenery, extra)
    has = {effect.name for effect in extra}
    kinds = catalogue().values() if kinds is None else kinds
    wanted = [kind for kind in kinds if not kind.base and kind.name not in has]
    predicted = predict(known, wanted, strength, watch)
    watch("choosing shots")
    front, best, told = choose(predicted, [shot.label for shot in shots], most_frames)
    chosen = [
        dataclasses.replace(shot, frames=best.frames) for shot in shots if shot.label in best.shots
    ]
    paper = of_the_paper(lamps)
    reference = None
    if paper:
        separated = len(predicted.told_by(paper, GROUPS[-1]).separated)
        reference = Step(shots=paper, frames=GROUPS[-1] * GROUP_FRAMES, separated=separated)
    return Recommendation(
        protocol=Protocol(name=f"recommended-{camera.name}", shot=tuple(chosen)),
        told=told,
        front=front,
        reference=reference,
    )


def choose(
    predicted: Prediction, labels: Sequence[str], most_frames: int | None = None
) -> tuple[tuple[Step, ...], Step, Separability]:
    """Shots one by one, each the one that helps most; then frames of each.

    Returns:
        the front of protocols, the one that separates most for the fewest frames, and what it
        tells.
    """
    order: list[str] = []
    while len(order) < min(MOST_SHOTS, len(labels)):
        left = [label for label in labels if label not in order]
        merits = {label: predicted.told_by([*order, label], SEARCHED).merit for label in left}
        order.append(max(merits, key=lambda label: merits[label]))
    tried: list[tuple[Step, Separability]] = []
    for count in range(1, len(order) + 1):
        for groups in GROUPS:
            if most_frames is not None and count * groups * GROUP_FRAMES > most_frames:
                continue
            found = predicted.told_by(order[:count], groups)
            step = Step(
                shots=tuple(order[:count]),
                frames=groups * GROUP_FRAMES,
                separated=len(found.separated),
            )
            tried.append((step, found))
    tried.sort(key=lambda one: (one[0].total, -one[0].separated))
    front: list[Step] = []
    for step, _ in tried:
        if not front or step.separated > front[-1].separated:
            front.append(step)
    best = front[-1]
    return tuple(front), best, next(found for step, found in tried if step is best)
