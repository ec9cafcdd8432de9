"""How the demosaicer of a model counts, and how strong its last effect is, asked anew."""

from __future__ import annotations

from analysis.gap.calibrate.counting import counted, in_finer_codes
from analysis.gap.calibrate.refine import Refined, further
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from analysis.gap.suspects.anew import ANEW_STEPS
from analysis.gap.suspects.valley import another_valley
from sensor.effect import Stage


def recounted(now: Refined, seen: Observation, scenery: Scenery) -> Refined:
    """The model with the way of counting, and with the strength of processing, that are likelier;
    the same where there are none.

    Args:
        now: the camera with its effects.
        seen: the frames that fit.
        scenery: their light and shots.
    """
    last = now.effects[-1]
    other = counted(now, seen, scenery, enough=0.0)
    if other is now:
        again = in_finer_codes(now, seen, scenery)
    else:
        again = further(other, seen, scenery, steps=ANEW_STEPS, tuned=last.name)
    # what is done to whole codes is fitted where it was found, by another way of counting; and of
    # what sets in above a threshold a step that is too long leaves nothing to step back by
    sets_in = any(p.inverse for p in last.parameters())
    jumps = last.stage is Stage.PROCESSING or sets_in
    valley = another_valley(again, seen, scenery) if jumps else None
    if valley is None:
        return again
    return further(valley, seen, scenery, steps=ANEW_STEPS, tuned=last.name)
