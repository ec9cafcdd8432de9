"""What no name passes: kinds of answer that were right less often than they seemed.

A score says how well an effect explains these frames, and not how often answers of its kind have
been right. Each cap here is the largest probability of one kind of name, by what was seen where it
was tuned; of a name the smallest of them counts.
"""

from __future__ import annotations

from collections.abc import Sequence

from analysis.gap.camera.base import Body
from analysis.gap.look.missing_codes import missing_everywhere
from analysis.gap.look.texture import FAMILY as TEXTURE
from analysis.gap.measure.case import Candidate
from analysis.gap.ready.setting import Setting
from analysis.gap.report import Gap, Verdict
from analysis.gap.search.choice import NARROWEST_PATCH_PX, TELLS_LITTLE
from analysis.gap.search.closing import against, closed, untouched
from analysis.gap.search.later import stands_beside
from analysis.gap.search.trail import Trail
from analysis.gap.suspects.separating import confused
from sensor.effect import Effect, Stage
from sensor.effects.adc_dnl import AdcDnl
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.crosstalk import Crosstalk
from sensor.effects.specular_glare import SpecularGlare
from sensor.effects.vibration import Vibration

MOST_CERTAIN = 0.95
MOST_IN_PART = 0.85
"""Probabilities that no name passes, where nothing is left with it and where something is. On four
sets of withheld effects 35 of 39 names were right that were given with 0.99 in the one case, and 16
of 23 in the other: what is in no catalogue may look like what is."""

MOST_AGAINST = 0.45
"""The same where something speaks against the model beyond doubt: likelier not than so."""

EDGES = frozenset({TEXTURE})
OF_MOVED_EDGES = frozenset({TEXTURE, "frames"})
"""Families that tell where edges lie to a part of a pixel, and how sharp they are: the structure of
the picture, and of one that moves also how much of it sites of a mosaic see from frame to frame."""

NEARLY_ALL = 0.9
MOST_BUT_TEXTURE = 0.6
"""Part of a gap that an effect of the optics closes, and the largest probability of its name, where
the structure of the picture alone speaks against it. Edges that lie a sixth of a pixel elsewhere
leave that much: a lateral colour by somebody else, whose panels end on thirds of a pixel, left 19 %
of texture and 7 % of G 5.3, its score 29,378 ahead of the next one's 26,256, and had no name. So
had a vibration by another one, whose panels end on quarters, 2 % of G 25.4, its score 143,896."""

OF_ROWS = frozenset({"row_noise", "black_level_drift", "flicker_noise"})
"""Noise that rows have in common, each with its own spectrum. Where one of them leaves something
another one may be the cause: of six such names of the bench (seeds 21 to 26) none was right."""

CONTESTED = 0.3
"""Part of its score from which another one of them is its rival. Of docs/another-camera.md four
such names were right (seeds 71 to 73): of seed 73 row noise had 27 times the score of flicker
noise, and flicker noise 1.1 times that of a drift."""

A_REMAINDER = 1e-3
"""Part of a gap below which what a later effect closes may be what the first one's model is off by.
Full photosites closed all but 3e-4 of a G of 405 (the bench, seed 35); a converter's unequal steps,
which that camera did not have, closed the rest."""

LARGEST_MISMATCH = 0.99 * next(p.maximum for p in AdcDnl.parameters() if p.name == "unit_mismatch")
"""Of a converter's unit elements. On the bench (seeds 21 to 39) those that were there came out with
0.1 at most; with the largest there is stood a blooming, and a table of 256 codes between 12 bits
and 12, which is in no catalogue, had 0.85."""

HIDE_A_CONVERTER = frozenset({Stage.PROCESSING, Stage.TRANSPORT})
"""Stages behind which no code tells how its converter counts."""

WIDEST_PATCH = 0.45
"""Part of the shorter side of a picture that the standard deviation of a patch of light does not
pass. One that is wider lights all of the picture, as a veil does: of the bench (seeds 12 to 24) and
of set 13 of the withheld effects six were named that were wider, 0.48 to 1.13, five for a
veil and one for a gamma; of ten narrower ones seven were right, 0.22 to 0.39."""


def most_of(place: int, word: Verdict, gap: Gap, found: Trail, setting: Setting) -> float:
    """The probability that a name does not pass.

    Args:
        place: of the effect among those that are named.
        word: the verdict.
        gap: without and with the effects.
        found: from the base camera to the last model.
        setting: the capture.
    """
    names = [choice.best.name for choice in found.choices]
    halves = 1.0 if lost_bits(found.choices[place].best) else most_of_several(names, place)
    model = found.models[-1]
    effect = next(one for one in model.effects if one.name == names[place])
    return min(
        most_of_a_name(word, found),
        halves,
        most_of_a_shape(effect, model.scenery.body),
        most_of_a_converter(effect, model.effects, setting),
        most_of_a_remainder(gap.before, [one.held.total for one in found.measured[1:]], place),
        most_beside_a_larger(found, place),
    )


def most_of_a_name(word: Verdict, found: Trail) -> float:
    """The probability that no name passes."""
    if word == "explained":
        return MOST_CERTAIN
    if not found.choices:
        return MOST_IN_PART
    best = found.choices[0].best
    if lost_bits(best):
        return MOST_IN_PART
    witnesses = against(found.measured[0], found.measured[-1])
    of_edges = OF_MOVED_EDGES if best.name == Vibration.name else EDGES
    if witnesses and of_edges.issuperset(witnesses) and _moves_nearly_all(found):
        return MOST_BUT_TEXTURE
    return MOST_AGAINST if witnesses or _contested(found) else MOST_IN_PART


def lost_bits(found: Candidate) -> bool:
    """Whether a suspect is lost bits that the frames tell: what has one value in every sample is
    lost, whatever else is wrong, and is no half of anything.
    """
    return found.name == BitTruncation.name and found.told is not None


def _moves_nearly_all(found: Trail) -> bool:
    """Whether the only name is one of the optics, with which a tenth of the gap is left at most."""
    base, last = found.measured[0], found.measured[-1]
    alone = len(found.choices) == 1 and found.choices[0].best.effect.stage is Stage.OPTICS
    return alone and closed(base.held.total, last.held.total) >= NEARLY_ALL


def _contested(found: Trail) -> bool:
    """Whether the first name is noise of rows, and another noise of rows may be it: one that was
    tried and leaves far more is not.
    """
    first = found.choices[0]
    best = first.best
    others = (c for c in found.candidates if c.name in OF_ROWS - {best.name} - first.beaten)
    return best.name in OF_ROWS and any(c.score > CONTESTED * best.score for c in others)


def most_of_several(names: Sequence[str], place: int) -> float:
    """The probability that a name does not pass for those it is given with.

    Two that are easily confused may be halves of a third which is as easily confused with them: row
    noise that was withheld was flicker noise with interference beside it. Of eight such pairs of
    the bench (seeds 12, 13, 20 to 22) two were right.

    Args:
        names: all that are given, in the order in which they were added.
        place: of the name among them.
    """
    others = [*names[:place], *names[place + 1 :]]
    halves = any(confused(names[place], other) for other in others)
    return MOST_AGAINST if halves else 1.0


FARTHEST = 0.99 * next(p.maximum for p in Crosstalk.parameters() if p.name == "to_corners")
"""Of a crosstalk, to corners. One that goes farther than charge does is a leak between filters,
which has no sides: of the bench (seeds 43 and 47) two of these that were withheld went 0.32 to
corners, with 0.95."""

ONE_SIDED = 0.15
"""By how much the part of a crosstalk that goes along the rows may differ from one half. Charge
that trails does so along one axis: of the bench (seeds 21 to 47) and set 24 of the withheld effects
four were named with 0.69 to 0.76 of it along the rows, all for deferred charge; of 20 right ones
none had more than 0.54, and of another engineer's, who made it so, 0.60."""


def most_of_a_shape(effect: Effect, body: Body) -> float:
    """The probability that a name does not pass for what it would look like.

    Args:
        effect: as it was fitted.
        body: which gives the size of the picture.
    """
    if isinstance(effect, Crosstalk):
        one_sided = abs(effect.along_rows - 0.5) > ONE_SIDED
        return MOST_AGAINST if one_sided or effect.to_corners >= FARTHEST else 1.0
    if not isinstance(effect, SpecularGlare):
        return 1.0
    widest_px = WIDEST_PATCH * min(body.height, body.width)
    return 1.0 if NARROWEST_PATCH_PX <= effect.sigma_px <= widest_px else MOST_AGAINST


def most_of_a_remainder(before: float, left: Sequence[float], place: int) -> float:
    """The probability that the name of a later effect does not pass.

    Args:
        before: G without any effect.
        left: G with the first, with the first two, and so on.
        place: of the effect among those that are named.
    """
    remainder = A_REMAINDER * before
    if place == 0 or remainder < TELLS_LITTLE:
        return 1.0
    return MOST_AGAINST if left[place - 1] - left[place] < remainder else 1.0


def most_beside_a_larger(found: Trail, place: int) -> float:
    """The probability that the name of a later effect does not pass beside one that is so much
    larger that it may be what the first one's model is off by, unless it closes what that one
    leaves alone.

    A picture that was distorted by straight lines between its points is a little softer: of G 1.01
    a defocus closed the last 0.014, with 2 % of the score.

    Args:
        found: from the base camera to the last model.
        place: of the effect among those that are named.
    """
    if place == 0:
        return 1.0
    base, before, after = found.measured[0], found.measured[place], found.measured[place + 1]
    left_alone = (set(untouched(base, one, worth=0.0)) for one in (before, after))
    own = set.difference(*left_alone)
    later, first = found.choices[place].best, found.choices[0].best
    return 1.0 if own or stands_beside(later, first) else MOST_AGAINST


def most_of_a_converter(effect: Effect, effects: Sequence[Effect], setting: Setting) -> float:
    """The probability that a converter's name does not pass.

    A table of codes behind everything looks like one that leaves codes out, except where colours
    were filled in. And behind a converter of more bits than leave the camera codes are uneven by
    its gains, which what is done to pictures hides: beside that its errors were named once on the
    bench (seeds 21 to 39), for nothing. Nor is one whose unit elements differ by as much as can be
    a converter: that fits whatever leaves codes out.

    Args:
        effect: as it was fitted.
        effects: all that are in the model.
        setting: the capture.
    """
    if not isinstance(effect, AdcDnl):
        return 1.0
    hidden = any(one.stage in HIDE_A_CONVERTER for one in effects)
    if hidden or effect.unit_mismatch >= LARGEST_MISMATCH:
        return MOST_AGAINST
    lit = [frames.dn for frames in setting.key_frames if not frames.shot.dark]
    view = setting.scenery.view
    return MOST_AGAINST if missing_everywhere(lit, view.lattices, view.top_dn) else 1.0
