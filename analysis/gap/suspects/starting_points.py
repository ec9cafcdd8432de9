"""Where a calibration with a suspect in the camera begins, the likeliest first."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from analysis.gap.calibrate.counting import by_rule, counted
from analysis.gap.calibrate.refine import FAR, Refined, refined
from analysis.gap.camera.base import Base, channels_alike
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.arithmetic import IN_FRACTIONS, OF_QUARTERS, OF_WHOLE_SAMPLES
from analysis.gap.measure.case import MISFIT, Case
from analysis.gap.ready.hints import DirectReading
from analysis.gap.suspects.beginnings import as_dark, choices, every_choice, uncoded
from analysis.gap.suspects.mend import Tried
from sensor.effect import Effect, Stage

Way = tuple[Base, Effect]

AS_LIKELY = 1.2
"""Times the misfit of a suspect's likeliest choice up to which another may be the right one. The
camera is not calibrated with it yet: halves that go up move a black level that can be found. The
right one of OpenCV's chroma had 1.09 in a case of set 14 of withheld effects, that of
the catalogue's 1.14 in one of set 17."""

MAYBE_LIKELY = 2.0
"""The same of a camera with the noise that it was calibrated with, not twice of it: a quiet one is
hardly any quieter behind a cable, and its darks tell how quiet. The right choice had 1.4 times the
misfit of the likeliest with twice the noise, and a third of it as it was (set 20 of withheld
effects)."""

LED = 0.9
"""Part of what a suspect left as it was found, below which a way led somewhere."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StartingPoints:
    """Cameras and effects from which small steps may lead to the right ones.

    Attributes:
        case: the capture.
        scenery: shots, under the light of the suspect.
        as_found: the suspect and the camera as they were fitted so far.
        base, effect: from which the search goes on: these, or what it began with.
        told: what the frames tell of the suspect.
        tuned: whether its parameters are fitted: not where frames tell them to the last digit.
    """

    case: Case
    scenery: Scenery
    as_found: Tried
    base: Base
    effect: Effect
    told: DirectReading | None
    tuned: bool

    def _against(self, base: Base, effect: Effect) -> Refined:
        """A camera with the suspect against the frames, by its own errors: what makes figures
        scatter leaves much by those of others.
        """
        effects = (*self.case.known.effects, effect)
        return refined(base, self.case.fit_seen, self.scenery, effects)

    @property
    def _coloured(self) -> bool:
        return "G" in self.base.channels

    @property
    def _coded(self) -> bool:
        return self.effect.stage is Stage.TRANSPORT

    @property
    def _even(self) -> Base:
        """The base with all channels as green is, which a suspect harms least."""
        return channels_alike(self.base) if self._coloured else self.base

    @cached_property
    def _unhidden(self) -> list[Refined]:
        """The likeliest choices of a suspect that hides the camera behind it, before that camera as
        it may have been; none of other suspects, and where frames tell the camera.
        """
        choose = self.tuned or self._coded
        hints = self.told.hints if self.told else None
        chosen = every_choice(self.effect, hints) if choose else [self.effect]
        hides = len(chosen) > 1 if self._coded else not self.tuned
        if (self.told and self.told.base) or not hides:
            return []
        tried = [self._against(uncoded(self._even), one) for one in chosen]
        possible = _within(MAYBE_LIKELY, tried)
        as_it_is = dataclasses.replace(self._even, arithmetic=IN_FRACTIONS)
        tried += [self._against(as_it_is, one.effects[-1]) for one in possible]
        best: dict[tuple[Effect, ...], Refined] = {}
        for one in sorted(_within(AS_LIKELY, tried), key=lambda one: one.misfit):
            best.setdefault(one.effects, one)
        return list(best.values())

    @property
    def _likely(self) -> Effect:
        return self._unhidden[0].effects[-1] if self._unhidden else self.effect

    def of_what_is_hidden(self, best: Tried) -> Iterator[Way]:
        """With what the suspect hides given back: levels of darks, noise, edges."""
        for one in self._unhidden:
            effect = one.effects[-1]
            if not self.tuned:
                yield as_dark(self._against(self._even, effect), self.case.fit_seen), effect
            yield one.base, effect
            if self.tuned:
                # one that rounds leaves the noise of its steps in the dark current of the base
                whole = dataclasses.replace(self.base, arithmetic=IN_FRACTIONS)
                yield as_dark(self._against(whole, effect), self.case.fit_seen), effect

    def behind_a_codec(self, best: Tried) -> Iterator[Way]:
        """From there with the other ways in which the camera may count, which a codec hides too."""
        if self._coded and self._unhidden and best is not self.as_found:
            base, effect = best[1].base, best[1].effects[-1]
            for rule in self._rules(base.arithmetic)[1:]:
                yield dataclasses.replace(base, arithmetic=rule), effect

    def by_counting(self, best: Tried) -> Iterator[Way]:
        """As the camera seems to count, with all channels alike and as they are."""
        if self._given_back_it_fits(best):
            return
        if self._coloured:
            yield self._counted(self._against(self._even, self._likely)), self._likely
        yield self._as_counted, self._likely

    def by_every_rule(self, best: Tried) -> Iterator[Way]:
        """With each other way in which the camera may count, where that cannot be seen: behind what
        is done to pictures, and far from the camera, if the ways so far led anywhere.
        """
        if self._given_back_it_fits(best):
            return
        hidden = self.effect.stage in (Stage.PROCESSING, Stage.TRANSPORT)
        led = best[1].misfit < LED * self.as_found[1].misfit
        if not hidden and (not led or self.case.misfit <= FAR):
            return
        # steps of lost bits are the same by any rule, and so is all that is seen of them
        first, *others = (
            dataclasses.replace(self.base, arithmetic=rule)
            for rule in self._rules(self._as_counted.arithmetic)
        )
        seen = {self._against(first, self._likely).chi2}
        for base in others:
            chi2 = self._against(base, self._likely).chi2
            if chi2 not in seen:
                yield base, self._likely
            seen.add(chi2)

    def by_choosing(self, best: Tried) -> Iterator[Way]:
        """With each other choice of the suspect; one of processing, which hides how the camera
        counts, as strong and by that way of counting as were the likeliest so far.
        """
        if self._given_back_it_fits(best):
            return
        base, effect = self.base, self._likely
        if effect.stage is Stage.PROCESSING and best is not self.as_found:
            base, effect = by_rule(base, best[1].base.arithmetic), best[1].effects[-1]
        for other in choices(effect):
            if not self._told_otherwise(other):
                yield self._counted_with(base, other), other

    def _told_otherwise(self, other: Effect) -> bool:
        """Whether a choice is another one than frames tell to the last digit."""
        exact = self.told.hints if self.told and self.told.exact else {}
        return any(getattr(other, name) != value for name, value in exact.items())

    def once_more(self, best: Tried) -> Iterator[Way]:
        """From the best so far, with all channels alike."""
        if self._coloured and best is not self.as_found:
            yield channels_alike(best[1].base), best[1].effects[-1]

    def _given_back_it_fits(self, best: Tried) -> bool:
        """Whether a colour camera with what the suspect hides leaves so little that no other way is
        gone.
        """
        led = bool(self._unhidden) and best is not self.as_found
        return self._coloured and led and best[1].misfit <= MISFIT

    @cached_property
    def _as_counted(self) -> Base:
        """The base without a change of its figures, as it seems to count."""
        found, measured = self.as_found
        as_it_was = self.base is found.base and self._likely == found.effect
        return self._counted(measured if as_it_was else self._against(self.base, self._likely))

    def _counted_with(self, base: Base, other: Effect) -> Base:
        """The base with another choice: another rule by which colours are filled in shows another
        way of counting.
        """
        if other.stage is not Stage.PROCESSING:
            return self._as_counted
        return self._counted(self._against(base, other))

    def _counted(self, begun: Refined) -> Base:
        return counted(begun, self.case.fit_seen, self.scenery).base

    def _rules(self, first: int) -> list[int]:
        """Rules by which the camera may count, beginning with one."""
        others = [rule for rule in (IN_FRACTIONS, OF_WHOLE_SAMPLES, OF_QUARTERS) if rule != first]
        return [first, *(rule for rule in others if rule in self.scenery.rules)]


def _within(times: float, tried: list[Refined]) -> list[Refined]:
    """Cameras that leave at most so many times the misfit that the best one leaves."""
    least = min(one.misfit for one in tried)
    return [one for one in tried if one.misfit <= times * least]
