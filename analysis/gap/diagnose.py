"""The whole diagnosis: calibrate, measure the gap, ask every suspect, and say what may be said."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from analysis.gap.calibrate.counting import (
    balanced,
    counted,
    in_finer_codes,
    with_likelier_gains,
    without_gains,
)
from analysis.gap.calibrate.darks import Darks, darks_by_light, darks_of
from analysis.gap.calibrate.finer_light import with_finer_light
from analysis.gap.calibrate.first_guess import first_guess
from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.calibrate.hidden import with_even_spread
from analysis.gap.calibrate.refine import FAR, Refined, as_shown, further, refine
from analysis.gap.camera.base import camera_of
from analysis.gap.look.arithmetic import FINER, OF_WHOLE_SAMPLES
from analysis.gap.ready.setting import Setting, halves, look, too_little
from analysis.gap.report import GapReport
from analysis.gap.search.follow import follow
from analysis.gap.search.step import Watch
from analysis.gap.search.trail import Trail
from analysis.gap.verdict.conclude import TOO_FEW, conclude, insufficient
from analysis.gap.verdict.first_frames import lag_of
from foundation.cores import libraries_beside_other_work
from render.rate import RateImage
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.white_balance import WhiteBalance
from sensor.frames import Capture


def calibrated(setting: Setting, nominal: Camera | None) -> Fit:
    """The base camera of a capture, from the frames that fit."""
    fit_half, _ = halves(setting.seen)
    scenery, counting = setting.scenery, setting.counting
    # what is calibrated is so whatever the camera says of it
    own = (BlackLevelOffset, WhiteBalance) if counting.gains else (BlackLevelOffset,)
    effects = tuple(
        e
        for e in (nominal.effects if nominal is not None else ())
        if not e.base and not isinstance(e, own)
    )

    def fitted(dark: Darks) -> Refined:
        start = counting.of(first_guess(fit_half, scenery, nominal, dark))
        if counting.gains:
            start = balanced(start, counting.gains[0])
        return refine(start, fit_half, scenery, effects)

    dark = darks_of(fit_half, scenery, setting.black_dn)
    best = fitted(dark)
    by_light = darks_by_light(fit_half, scenery) if dark.quiet else None
    if by_light is not None:
        best = min(best, fitted(by_light), key=lambda one: one.deviance)
    best = with_finer_light(best, fit_half, scenery, setting.capture.frames)
    best = with_even_spread(best, dark, fit_half, scenery, effects)
    best = with_likelier_gains(best, fit_half, scenery, counting.gains)
    best = without_gains(best, fit_half, scenery)
    # codes alone leave open whether means of what is multiplied afterwards are whole
    open_yet = counting.gains and counting.arithmetic in (OF_WHOLE_SAMPLES, *FINER)
    other = counted(best, fit_half, scenery, enough=0.0 if open_yet else FAR)
    if other is not best:
        best = further(other, fit_half, scenery)
    if scenery.light.known:
        scenery = as_shown(best, scenery)
        best = refine(best.base, fit_half, scenery, effects)
    best = in_finer_codes(best, fit_half, scenery)
    return around(best.base, scenery, effects)


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """Everything that a diagnosis found, for those who want more than the report.

    Attributes:
        report: what may be said.
        setting: the capture, its plan and its light; None where it has too few frames.
        trail: the base, the effects that the report names, and the distance from each; the same.
    """

    report: GapReport
    setting: Setting | None = None
    trail: Trail | None = None

    @property
    def camera(self) -> Camera | None:
        """The camera with everything that was found, in the units of its own light."""
        if self.trail is None:
            return None
        last = self.trail.models[-1]
        made = camera_of(last.base, last.scenery.body).plus(*last.effects)
        lag = lag_of(self.setting.begins) if self.setting else None
        by_first_frames = {one.name for one in self.report.effects} - {e.name for e in last.effects}
        if lag is not None and lag.name in by_first_frames:
            made = made.plus(lag)
        if not last.base.level or not last.scenery.light.in_electrons:
            return made
        level = np.mean(list(last.base.level.values()), axis=0)
        level = np.repeat(level, 3) if len(level) == 1 else level
        sensitivity = Colours(R=float(level[0]), G=float(level[1]), B=float(level[2]))
        return dataclasses.replace(made, sensitivity=sensitivity)


@libraries_beside_other_work()
def diagnose(
    capture: Capture,
    model: Camera | None = None,
    *,
    stated: Mapping[str, RateImage] | None = None,
    suspects: Iterable[type[Effect]] | None = None,
    watch: Watch = lambda what: None,
) -> Diagnosis:
    """Where a simulated camera differs from the one that took these frames, and why.

    Args:
        capture: the frames.
        model: a camera to start from; its effects beyond the base count as known.
        stated: rate images by lamp, where they are known.
        suspects: kinds of effect; all of the catalogue by default.
        watch: told what is being done.

    Raises:
        InputError: for a scene that the frames do not show.
    """
    began = time.monotonic()

    def timed(report: GapReport) -> GapReport:
        return dataclasses.replace(report, seconds=time.monotonic() - began)

    trouble = too_little(capture)
    setting = None if trouble else look(capture, stated or {})
    if setting is None:
        return Diagnosis(report=timed(insufficient(trouble or TOO_FEW)))
    watch("calibrating the base camera")
    known = calibrated(setting, model)
    kinds = [k for k in (catalogue().values() if suspects is None else suspects) if not k.base]
    report, trail = conclude(setting, follow(setting, known, kinds, watch))
    return Diagnosis(report=timed(report), setting=setting, trail=trail)
