"""The word of a report: matched, explained, partly explained, unexplained. Never a guess."""

from __future__ import annotations

from analysis.gap.report import Gap, Verdict
from analysis.gap.search.choice import (
    LEAST_SHRINK,
    MAY_BE_NOTHING,
    MOST_CAUSES,
    SIGNIFICANCE,
    TELLS_LITTLE,
)


def word_of(effects: int, gap: Gap, untouched: bool = False) -> Verdict:
    """The word of the report.

    Args:
        effects: number of effects that were added.
        gap: without and with them.
        untouched: whether something that is wrong beyond doubt is as it was.
    """
    if effects == 0:
        return "matched" if gap.p_value_before >= SIGNIFICANCE else "unexplained"
    if effects > MOST_CAUSES:
        return "unexplained"
    if gap.p_value_after >= SIGNIFICANCE:
        return "explained"
    # near the floor, and where nothing may be left, the total tells little, but chances do: half of
    # their digits must be gone
    small = gap.at_floor or gap.before < TELLS_LITTLE
    little = small or gap.p_value_after > MAY_BE_NOTHING
    enough = gap.p_value_after**2 > gap.p_value_before if little else gap.shrink >= LEAST_SHRINK
    return "partly explained" if enough and not untouched else "unexplained"
