"""The report of what was found: the word, the names, the figures."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.gap.calibrate.calibration_figures import calibration_figures
from analysis.gap.look.shots import FEWEST_FRAMES, FEWEST_SHOTS, GROUP_FRAMES
from analysis.gap.measure.case import Candidate
from analysis.gap.ready.setting import Setting
from analysis.gap.report import EQUIVALENT, NO_GAP, GapReport, Named, Suspect, Verdict
from analysis.gap.search.choice import (
    Choice,
    probabilities,
)
from analysis.gap.search.trail import Trail, gap_of, still_untouched
from analysis.gap.suspects.separating import next_capture
from analysis.gap.verdict.caps import lost_bits, most_of_a_name
from analysis.gap.verdict.first_frames import with_first_frames
from analysis.gap.verdict.places import places
from analysis.gap.verdict.strength import figure_of
from analysis.gap.verdict.trust import (
    DOUBT,
    LIKELIER,
    likelier_none,
    no_surer,
    probability_of,
    stands_out,
)
from analysis.gap.verdict.word import word_of

TOO_FEW = (
    f"fewer than {FEWEST_SHOTS} shots have {FEWEST_FRAMES} frames; {2 * GROUP_FRAMES} of each are"
    " needed to split them into frames that fit and frames that score"
)


def insufficient(trouble: str) -> GapReport:
    """The report of a capture that shows too little."""
    return GapReport(
        verdict="insufficient data",
        gap=NO_GAP,
        next_capture=f"darks and lit shots of {2 * GROUP_FRAMES} or more frames, not saturated",
        notes=(trouble,),
    )


def _with(suspect: Candidate, found: Trail) -> float:
    """G with a suspect: of the model that was made with it, where there is one; else by how much it
    takes off by the errors of the model without it.
    """
    if found.choices and suspect.name == found.choices[0].best.name:
        return found.measured[1].held.total
    if suspect.model is not None:
        return suspect.off
    before = found.measured[0]
    return before.held.total - suspect.forward / float(before.rod.spread.expected.sum())


def conclude(setting: Setting, found: Trail) -> tuple[GapReport, Trail]:
    """The report of what was found, and the part of it that the report speaks of."""
    gap = gap_of(found)
    word = word_of(len(found.choices), gap, still_untouched(found, setting.told))
    each = range(len(found.choices))
    chances = no_surer(
        [probability_of(k, word, gap, found, setting) for k in each],
        [lost_bits(choice.best) for choice in found.choices],
    )
    if word == "partly explained" and likelier_none(found.choices, chances):
        word = "unexplained"
    if word == "unexplained":
        found, chances = _as_it_began(found, setting)
        word = "partly explained" if found.choices else word
        gap = gap_of(found)
    before, after = found.measured[0], found.measured[-1]
    doubt = 1.0 if found.choices or not found.candidates else DOUBT
    weights = found.choices[0].by_name if found.choices else probabilities(found.candidates)
    most = most_of_a_name(word, found)
    report = GapReport(
        verdict=word,
        effects=strongest_first(
            [
                _named(choice, chance, found)
                for choice, chance in zip(found.choices, chances, strict=True)
            ],
            found.candidates,
        ),
        candidates=tuple(
            Suspect(
                name=c.name,
                probability=min(most, float(weights.get(c.name, 0.0)) * doubt),
                gap=_with(c, found),
                calibration_equivalent=c.absorbed > EQUIVALENT,
                score=c.score,
            )
            for c in found.candidates
        ),
        gap=gap,
        where=places(before, _nearest(found), setting),
        next_capture=_wanted(word, found),
        calibration=calibration_figures(found.models[-1], after.errors),
        notes=notes_of(setting),
    )
    return with_first_frames(report, setting.begins), found


def _as_it_began(found: Trail, setting: Setting) -> tuple[Trail, list[float]]:
    """The first effect alone, with the probability of its name, where it stands out; or none."""
    if found.lead is None or (chance := stands_out(found.lead, setting)) < LIKELIER:
        return found.first(), []
    return found.lead, [chance]


def _nearest(found: Trail) -> Candidate | None:
    """What is named first, or else what closes most of the gap; None where no suspect does."""
    if found.choices:
        return found.choices[0].best
    closing = [c for c in found.candidates if c.forward > 0]
    return max(closing, key=lambda c: c.forward, default=None)


def _wanted(word: Verdict, found: Trail) -> str | None:
    """The capture that would tell more; None where it is not needed."""
    if word == "unexplained":
        return next_capture([c.name for c in found.candidates[:2]])
    confused = [[c.best.name, *(one.name for one in c.alike)] for c in found.choices if c.alike]
    return next_capture([name for names in confused for name in names]) if confused else None


def strongest_first(named: Sequence[Named], candidates: Sequence[Candidate]) -> tuple[Named, ...]:
    """The names by their scores before any effect was added: one that was chosen anew beside a
    weaker one was added after it.
    """
    scores = {c.name: c.score for c in candidates}
    return tuple(sorted(named, key=lambda one: -scores.get(one.name, 0.0)))


def _named(choice: Choice, probability: float, found: Trail) -> Named:
    best, model, after = choice.best, found.models[-1], found.measured[-1]
    effect = next(e for e in model.effects if e.name == best.name)
    return Named(
        name=best.name,
        probability=probability,
        indistinguishable_from=tuple(c.name for c in choice.alike),
        absorbed=best.absorbed,
        parameters={p.name: figure_of(effect, p, model, after, best) for p in effect.parameters()},
    )


def notes_of(setting: Setting) -> tuple[str, ...]:
    """What a reader must know of how the capture was used."""
    notes = [f"light: {setting.scenery.light.source}"]
    if not setting.scenery.light.known and setting.capture.lit:
        notes.append("the picture itself is not judged, only what differs between shots of a lamp")
    if setting.counting.corners:
        notes.append("measured greens are averaged with those at their corners: calibrated, no gap")
    if setting.plan.other:
        notes.append(f"not looked at, they would show the same: {', '.join(setting.plan.other)}")
    if setting.plan.unused:
        notes.append(f"too few frames to be used: {', '.join(setting.plan.unused)}")
    return tuple(notes)
