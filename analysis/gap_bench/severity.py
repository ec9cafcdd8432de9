"""How strong an effect is in a case: in detection limits of the very camera that has it.

Another camera sees it otherwise. Where samples are whole numbers before a filter in time, a
fiftieth of the frame before changes no code at all, and a camera of little noise sees more of what
drifts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.camera.light import light_of
from analysis.gap.look.shots import plan
from analysis.gap_bench.cases import Case
from analysis.gap_bench.draw import paper
from analysis.identifiability.known import base_of, scenery_of
from analysis.identifiability.limits import STANDARD_ERRORS, Limit, limits
from render.rate import RateImage
from sensor.camera import Camera
from sensor.effect import Effect
from sensor.record import record


def fit_of(camera: Camera, light: Mapping[str, RateImage], frames: int) -> tuple[Fit, int]:
    """A camera without effects as calibration would have it, and how many groups its shots have.

    Args:
        camera: whose figures are known.
        light: rate images by lamp.
        frames: of each of the paper's shots.
    """
    rates = {lamp: image.rate_e_per_s for lamp, image in light.items()}
    capture = record(camera, paper(frames), rates)
    chosen = plan(capture)
    assert chosen is not None, "the bench takes enough frames"
    shots = [f.shot for f in capture.frames if f.shot.label in chosen.key]
    panels = light_of(capture, light, camera.black_dn).panels
    scenery = scenery_of(camera, shots, rates, panels, chosen.frames)
    return around(base_of(camera, list(rates)), scenery), chosen.groups


def limits_of(
    light: Mapping[str, RateImage], frames: int, camera: Camera, effects: Sequence[Effect]
) -> dict[str, Limit]:
    """Detection limits of some effects in what one camera takes."""
    if not effects:
        return {}
    known, groups = fit_of(camera, light, frames)
    return limits(known, groups, effects)


THRESHOLD = 1.3
"""An effect whose limit stands further off than this begins at a threshold: it is seen well as soon
as it is seen at all."""


def severity_of(case: Case, limit: Limit) -> float:
    """Strength of the one effect of a case in detection limits.

    That of an effect that comes in steps is as far above the limit as this form of it stands, that
    of one that begins at a threshold as far as its weakest form.
    """
    part = limit.z / STANDARD_ERRORS
    if limit.steps:
        return part
    return case.strength * (part if part > THRESHOLD else 1.0)
