"""A capture made ready to be diagnosed: which frames, under which light, and what they show."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.filled_in import filled_in
from analysis.gap.calibrate.darks import black_of
from analysis.gap.camera.base import Body
from analysis.gap.camera.light import light_of
from analysis.gap.camera.twin import Scenery, exposure_of, shots_of
from analysis.gap.look.agreeing import green_is_averaged
from analysis.gap.look.comb import histograms
from analysis.gap.look.first_frames import Beginning, beginning, without_beginnings
from analysis.gap.look.lattices import BORDER_PX, Lattice, lattices_of, of_a_mosaic
from analysis.gap.look.observation import BLOCKS_DOWN, Observation, View
from analysis.gap.look.observe import begun
from analysis.gap.look.shots import Plan, plan, stack_of
from analysis.gap.ready.hints import DirectReading, empty_bits
from analysis.gap.ready.how_it_counts import HowItCounts, how_it_counts
from analysis.gap.ready.whole_codes import told_by_codes
from render.rate import RateImage
from sensor.camera import GREY, PRISM
from sensor.frames import MOSAICS, Capture, Frames

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """A capture made ready: its plan, its light, and what was seen of its key shots.

    Attributes:
        capture: the frames, without those at the beginning of shots that are unlike the rest.
        begins: how shots begin, where those frames were left out.
        plan: which of them take part.
        scenery: format, light and shots.
        seen: the key shots, looked at.
        black_dn: a first black level.
        counting: how the camera counts, by its codes alone.
        told: parameters of suspects that whole codes tell, by name of the effect.
    """

    capture: Capture
    begins: Beginning | None
    plan: Plan
    scenery: Scenery
    seen: Observation
    black_dn: float
    counting: HowItCounts
    told: Mapping[str, DirectReading]

    @property
    def key_frames(self) -> list[Frames]:
        """The frames of the key shots."""
        return [f for f in self.capture.frames if f.shot.label in self.plan.key]

    def darks(self, fewest: int) -> list[Frames]:
        """Dark shots of at least so many frames. What frames tell by themselves is held against no
        model, so that all of them may tell it, key shots or not.
        """
        return [f for f in self.capture.frames if f.shot.dark and f.count >= fewest]


def look(capture: Capture, stated: Mapping[str, RateImage]) -> Setting | None:
    """Everything that is known of a capture before any model; None where it has too few frames."""
    begins = beginning(capture)
    capture = without_beginnings(capture) if begins else capture
    chosen = plan(capture)
    if chosen is None:
        return None
    lattices = lattices_of(capture)
    first = capture.frames[0]
    down = (min(first.height, first.width * 3 // 4) - 2 * BORDER_PX) // lattices[0].step
    view = View(
        lattices=lattices,
        frames=chosen.frames,
        side=max(1, -(-down // BLOCKS_DOWN)),
        top_dn=first.top_dn,
    )
    keys = [f for f in capture.frames if f.shot.label in chosen.key]
    black_dn = black_of_frames(capture.frames)
    cfa = first.cfa or _cfa(lattices, keys)
    body = Body.of(first, cfa, capture.camera)
    seen = begun((stack_of(f, chosen) for f in keys), view)
    counts = histograms([f.dn for f in keys], lattices, first.top_dn)
    bits = empty_bits(keys, lattices)
    counting = dataclasses.replace(
        how_it_counts(
            capture.frames, keys, lattices, counts, bits, black_dn, fills_in=body.fills_in
        ),
        corners=green_is_averaged(keys, lattices),
    )
    scenery = Scenery(
        body=body,
        light=light_of(capture, stated, black_dn),
        shots=shots_of([f.shot for f in keys]),
        view=view,
        rules=counting.rules,
    )
    return Setting(
        capture=capture,
        begins=begins,
        plan=chosen,
        scenery=scenery,
        seen=seen(),
        black_dn=black_dn,
        counting=counting,
        told=told_by_codes(keys, bits, counts, black_dn, counting.slight),
    )


def black_of_frames(frames: Sequence[Frames]) -> float:
    """A first black level in DN."""
    darks = {f.shot.exposure_s: float(np.mean(f.dn[:4])) for f in frames if f.shot.dark}
    lit: dict[float, list[float]] = {}
    for f in frames:
        if not f.shot.dark:
            lit.setdefault(exposure_of(f.shot), []).append(float(np.mean(f.dn[:4])))
    return black_of(darks, lit)


def _cfa(lattices: Sequence[Lattice], stacks: Sequence[Frames]) -> str:
    """Colours of the pixels where nobody stated them; any mosaic where there is one and its phase
    does not show.
    """
    names = [lattice.channel for lattice in lattices]
    if names == ["Y"]:
        return GREY
    if of_a_mosaic(lattices):
        return "".join(names)
    return MOSAICS[0] if filled_in(stacks) else PRISM


def halves(seen: Observation) -> tuple[Observation, Observation]:
    """The groups that fit, and those that score: every other one."""
    return _part(seen, slice(0, None, 2)), _part(seen, slice(1, None, 2))


def _part(seen: Observation, groups: slice) -> Observation:
    return dataclasses.replace(seen, figures=seen.figures[groups], means=seen.means[groups])


def too_little(capture: Capture) -> str | None:
    """What makes a capture useless; None where nothing does."""
    lit = capture.lit
    if lit and all(float((f.dn[0] >= f.top_dn).mean()) > 0.5 for f in lit):
        return "every lit shot is saturated in more than half of its pixels"
    first = [np.asarray(f.dn[: min(2, f.count)]) for f in capture.frames]
    if all(int(np.ptp(dn)) == 0 for dn in first):
        return "all frames are of one value: there is neither a picture nor noise in them"
    if lit and all(int(dn.max()) == 0 for f, dn in zip(capture.frames, first, strict=True)
                   if not f.shot.dark):  # fmt: skip
        return "every lit shot is black"
    return None
