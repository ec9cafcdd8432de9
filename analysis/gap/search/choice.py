"""The suspect that frames name, how likely it is the one, and what they cannot tell from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from analysis.gap.measure.case import Candidate
from analysis.gap.report import EQUIVALENT
from analysis.gap.suspects.separating import confused
from sensor.effects.dust_shadow import DustShadow
from sensor.effects.specular_glare import SpecularGlare

SIGNIFICANCE = 0.05
"""A gap that chance makes more often is none."""

LEAST_SCORE = 15.0
"""Fall of chi-squared of a suspect that is named, where the gap as a whole is beyond chance. By
itself a suspect is evidence of a gap from a score of 19 on; see `p_of_best`."""

MARGIN = 9.0
"""By how much a suspect must beat one that is not named with it."""

LEAST_SHRINK = 0.8
"""Part of a gap that must be closed for its causes to be named where something is left: demanded of
the diagnosis, not measured."""

TELLS_LITTLE = 0.1
"""G below which the part of it that is closed says nothing of who closed it."""

MAY_BE_NOTHING = 0.01
"""Chance of what is left from which it may be nothing, however little of a small gap seems closed.
Of eight single names of the bench that left 0.01 to 0.05 six were right (seeds 21 to 35); the
effects of the other two were withheld."""

CLASS_SIZE = 2
"""Names that may stand beside the one given."""

MOST_OF_A_CROWD = 0.45
"""Probability of one of more suspects than may be named together, or of one beside which another
one fits better: likelier not than so."""

DRAWN = frozenset({"dust_shadow", "large_scale_prnu"})
"""Patterns that lie elsewhere in every body: twins tell how large they are and not where, and one
is taken for the other, whatever their scores. They are named together, neither with confidence."""

BUMPS = DRAWN | {SpecularGlare.name}
"""What makes a picture brighter or darker here and there. Beside a drawn pattern with which nothing
is left a patch of light is one of its bumps, whose place twins do not tell: beside grains of dust
that left p = 0.53 of somebody else's waves a patch had a score of 174."""

NARROWEST_PATCH_PX = 7.0
"""Standard deviation of a patch of light below which it is as small as a grain. Of the bench (seeds
21 to 36) and of docs/another-camera.md (6, 7, 80, 81) six were named that were narrower, 2 to 5 px:
five for grains of dust, four of these the same twelve grains, and one for nothing. The next wider
one had 10, and was one of waves."""

HALF_AS_LIKELY = 0.5
FITS_BETTER = 0.01
"""Part of the best score that a suspect which is easily confused with it has at least, and part of
chi-squared by which less is left with it, so that the two are named together: a score is told by
the scatter of twins along the suspect's own direction, and by what is left it is the other one. Of
nine cases of the bench (seed 34) that is so of one, a drift that was called a flicker."""

WEAK = 60.0, 150.0
"""Scores up to which a name is doubted most, and from which it is not: signatures are not quite
right, and what is in no catalogue takes the name that looks most like it."""

DOUBTED = 0.4
"""Factor of the probability of a suspect that barely deserves its name: where this was tuned, about
half of the names that were given at scores of 15 to 40 were right, and of seven that were given at
45 to 110 since (seeds 23 and 24 of the bench, and 71 of docs/another-camera.md) four."""

BEYOND_CALIBRATION = 60.0
"""Score of such an effect that is evidence by itself. Nulls have had up to 33, where calibration's
own directions are not quite straight: 19 was the highest of 144 of the bench (seed 17). Two of
them whose scores are no farther apart are named together, neither with confidence: of four of the
bench (seeds 21 to 39) two were right, and a lamp that had been moved was an error of the spectral
response with 0.95 in somebody else's raw camera, 153 against 121 and 107."""

TEMPER = 2.0
"""Scores are divided by this: signatures are simulated, and other people's effects are not ours."""


MARGIN_OF_SCORE = 0.1
TEMPER_OF_SCORE = 0.02
"""Parts of the best score that take their place where they are larger: a signature that is not
quite right loses some of its score, and one that is wrong may lose less. Of 32 right names for
faults of docs/another-camera.md one was ahead of the next by less than a tenth of its score; the
wrong one was, by 7 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """The suspect that these frames name.

    Attributes:
        best: the one.
        alike: others that the frames cannot tell from it, at most two.
        probability: that it is the one.
        by_name: the same for every candidate.
        beaten: names of others that were tried and leave far more.
    """

    best: Candidate
    alike: tuple[Candidate, ...]
    probability: float
    by_name: dict[str, float]
    beaten: frozenset[str] = frozenset()

    def instead(self, other: Candidate, candidates: Sequence[Candidate]) -> Choice:
        """Another one in place of that with the best score.

        Args:
            other: the one.
            candidates: all suspects, best first.
        """
        rest = 1.0 - CLOSES_ALONE
        by_name = {name: rest * chance for name, chance in self.by_name.items()}
        near = (self.best, *self.alike) if other in self.alike else ()
        alike = {c.name: c for c in (*_drawn_like(other, candidates), *near) if c is not other}
        return Choice(
            best=other,
            alike=tuple(alike.values())[:CLASS_SIZE],
            probability=CLOSES_ALONE,
            by_name=by_name | {other.name: CLOSES_ALONE},
        )


CLOSES_ALONE = 0.45
"""Probability of a suspect that closes a gap of which the one with the best score leaves some, or
that looks like it and is commoner: the likeliest single cause, but not likelier than not, as its
own signature is not the best."""


def telling(candidates: Sequence[Candidate], p_of_whole: float) -> Sequence[Candidate]:
    """The suspects that may be evidence of a gap, best first.

    Where the whole is no more than chance makes, what calibration takes up for nine tenths is none
    unless it is beyond doubt: of the tenth that is left the most is how straight calibration's own
    directions are. Where one of the others shows a gap, any may be its cause.

    Args:
        candidates: best first.
        p_of_whole: chance of the whole.
    """
    if p_of_whole < SIGNIFICANCE:
        return candidates
    others = [c for c in candidates if c.absorbed <= EQUIVALENT or c.score > BEYOND_CALIBRATION]
    shown = choose(others) is not None and both(p_of_whole, p_of_best(others)) < SIGNIFICANCE
    return candidates if shown else others


FREEDOM = 15.0
"""Degrees of freedom of Student's t by which the chance of a score is told. The twins that tell the
error along a direction would make it 23, but bodies are not alike in it: of 72 nulls of the bench
(seed 11) five had a best score above 17, where a t of 23 has one, and a t of 15 three."""


def p_of_best(candidates: Sequence[Candidate], freedom: float = FREEDOM) -> float:
    """Chance that the best of so many suspects reaches its score where nothing is wrong.

    Args:
        candidates: best first.
        freedom: degrees of freedom of the standard error along its direction: Student's t.
    """
    if not candidates or candidates[0].score <= 0:
        return 1.0
    one = 2.0 * float(stats.t.sf(np.sqrt(candidates[0].score), freedom))
    return float(1.0 - (1.0 - one) ** len(candidates))


def both(first: float, second: float) -> float:
    """Chance that the smaller of two chances comes out this small."""
    return float(1.0 - (1.0 - min(first, second)) ** 2)


def choose(candidates: Sequence[Candidate]) -> Choice | None:
    """The suspect to name, or None where none reaches what is asked of it.

    Args:
        candidates: best first.
    """
    if not candidates or candidates[0].score < LEAST_SCORE:
        return None
    best, *others = candidates
    grain = _grain(candidates)
    margin = max(MARGIN, MARGIN_OF_SCORE * best.score)
    near = [c for c in others if c.score > best.score - margin]
    bent = [c for c in others if _as_bent(c, best)]
    better = [c for c in others if _fits_better(c, best)]
    rivals = list(
        {c.name: c for c in (*grain, *_drawn_like(best, others), *better, *bent, *near)}.values()
    )
    by_name = probabilities(candidates)
    doubted = best.name in DRAWN or bool(better or bent) or len(near) > CLASS_SIZE
    most = MOST_OF_A_CROWD if doubted else 1.0
    choice = Choice(
        best=best,
        alike=tuple(rivals[:CLASS_SIZE]),
        probability=min(most, by_name[best.name] * _trusted(best.score)),
        by_name=by_name,
    )
    return choice.instead(grain[0], candidates) if grain else choice


def _grain(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Dust, where the best suspect is a patch of light as small as a grain of it."""
    patch = candidates[0].effect
    if not isinstance(patch, SpecularGlare) or patch.sigma_px >= NARROWEST_PATCH_PX:
        return []
    least = max(LEAST_SCORE, HALF_AS_LIKELY * candidates[0].score)
    return [c for c in candidates if c.name == DustShadow.name and c.score >= least]


def _drawn_like(one: Candidate, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The other pattern that lies elsewhere in every body, if the suspect is one."""
    return [c for c in candidates if c is not one and {c.name, one.name} <= DRAWN]


def _as_bent(other: Candidate, best: Candidate) -> bool:
    """Whether calibration takes up both of two suspects, and what it leaves of them is no more
    apart than its own directions are from straight.
    """
    apart = best.score - other.score < BEYOND_CALIBRATION
    return min(other.absorbed, best.absorbed) >= EQUIVALENT and other.score > LEAST_SCORE and apart


def _fits_better(other: Candidate, best: Candidate) -> bool:
    """Whether a suspect of a lower score that is confused with the best leaves clearly less."""
    likely = other.score > HALF_AS_LIKELY * best.score and confused(other.name, best.name)
    # by the errors of one and the same model, and both by least squares
    alike = other.model is None and best.model is None and best.told is None
    return likely and alike and other.misfit < best.misfit - FITS_BETTER


def _trusted(score: float) -> float:
    """Factor of a probability by how much there is to judge by."""
    return float(np.interp(score, WEAK, (DOUBTED, 1.0)))


def probabilities(candidates: Sequence[Candidate]) -> dict[str, float]:
    """Of each suspect, by tempered likelihood; what is missing to 1 is that it is none of them."""
    scores = np.array([c.score for c in candidates])
    if len(scores) == 0:
        return {}
    temper = max(TEMPER, TEMPER_OF_SCORE * float(scores.max()))
    # "none of them" has the likelihood of a suspect that barely deserves its name
    weights = np.exp((np.append(scores, LEAST_SCORE - 2 * TEMPER) - scores.max()) / (2 * temper))
    return dict(zip((c.name for c in candidates), (weights / weights.sum())[:-1], strict=True))


MOST_CAUSES = 2
"""Effects that explain a gap together. Three at once are less likely than one that is in no
catalogue, of which each takes a part: a ghost was a veil, a glare and waves of the response. Of
eleven such answers of the bench (seeds 21 to 34) and of the sets of withheld effects seven were of
an effect that was in no library, three of other people's code for one that was, and one of a pair.
"""
