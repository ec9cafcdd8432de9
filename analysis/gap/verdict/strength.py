"""A fitted parameter as it is reported: after the last step of the fit, and with what error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.gap.calibrate.fit import Fit
from analysis.gap.camera.handles import Handle
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.distance import Distance
from analysis.gap.measure.measured import Measured
from analysis.gap.report import Figure
from analysis.gap.search.choice import SIGNIFICANCE
from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect, Parameter

FURTHEST = 0.25
"""Part of a threshold beyond which the last step of it is not made, and says nothing of how well it
is known: what grows by no power of it lies along no direction so far away."""


OF_A_SEARCH = 1.2
"""Times the errors of a fit that those of a search are. Where it began, which light and which
directions it chose on its way is chance as well, and no part of a fit's: of 93 strengths of single
effects of the bench (seeds 36 to 45) 79 were within 1.645 of these, and 84 within as much of those.
"""


def figure_of(
    effect: Effect, p: Parameter, model: Fit, after: Measured, found: Candidate
) -> Figure:
    """A parameter after the last step of the fit, with a standard error where it was fitted.

    Args:
        effect, p: the effect and its parameter.
        model, after: the camera with it, and the capture against that.
        found: the suspect that was added.
    """
    fitted = _by_the_fit(effect, p, model, after, found)
    return fitted if fitted.se is None else replace(fitted, se=OF_A_SEARCH * fitted.se)


def _by_the_fit(
    effect: Effect, p: Parameter, model: Fit, after: Measured, found: Candidate
) -> Figure:
    """A parameter after the last step of the fit, with the error of the fit alone.

    What frames tell by themselves is as it was told: a step of a fit by twins would make it worse.
    Of what is fitted no step is known better than it is long: steps that do not become shorter are
    along directions that change on the way, as those of whole codes do.

    Args:
        effect, p: the effect and its parameter.
        model, after: the camera with it, and the capture against that.
        found: the suspect that was added.
    """
    own = getattr(effect, p.name)
    colour = reported_colour(own, p) if isinstance(own, Colours) else "G"
    value = getattr(Colours.of(own), colour)
    channel = CHANNELS.index(colour) if isinstance(own, Colours) else None
    handle = Handle(effect=effect.name, parameter=p.name, channel=channel)
    told = found.told.get(p.name) if found.told is not None else None
    if handle not in model.ways.tuned:
        return Figure(value=value, se=told, unit=p.unit)
    place = len(model.ways.knobs) + model.ways.tuned.index(handle)
    error = float(after.errors[place]) * birge_ratio(after.whole)
    if not np.isfinite(error):
        return Figure(value=value, se=None, unit=p.unit)
    if told is not None:
        return Figure(value=value, se=max(error, told), unit=p.unit)
    moved = value
    if found.told is None:
        by = float(after.amounts[place])
        moved = last_step(p, value, by)
        error = float(np.hypot(error, min(abs(by), _reach(p, value))))
    if p.identity is not None:
        error = max(error, least_error(p, moved, found.score))
    return Figure(value=moved, se=error, unit=p.unit)


HARDLY_IN_GREEN = 0.1
"""Part of the strength in another colour below which green hardly has an effect."""


def reported_colour(own: Colours, p: Parameter) -> str:
    """The colour of which a parameter is reported: green, or the one that has most of the effect
    where green has hardly any. A leak of green light into red alone had been reported as none. The
    largest of three that differ by chance would be too large.

    Args:
        own: the parameter, by colour.
        p: its declaration.
    """
    if p.identity is None:
        return "G"
    off = {c: abs(getattr(own, c) - p.identity) for c in CHANNELS}
    most = max(off, key=lambda c: off[c])
    return most if off["G"] < HARDLY_IN_GREEN * off[most] else "G"


def birge_ratio(left: Distance) -> float:
    """Factor of standard errors by which the rest of a fit is as large as chance makes it.

    Errors are those of a model that is right. One that leaves more than chance does is not, and
    some of what it leaves may have gone into its parameters: as much more as the family that fits
    worst is off. Within chance the factor is 1.

        S = sqrt(chi-squared / expected)

    Reference: R. T. Birge, Phys. Rev. 40, 207 (1932).

    Args:
        left: distance of the frames from the model.
    """
    if left.p_value >= SIGNIFICANCE:
        return 1.0
    worst = min(left.p_by_family, key=lambda name: left.p_by_family[name])
    return float(np.sqrt(1.0 + max(left.by_family[worst], 0.0)))


def last_step(p: Parameter, value: float, by: float) -> float:
    """A parameter after the last step of the fit, inside its range.

    A strength is not moved to where the effect vanishes, or beyond: that there is one has been
    shown, and a step that says otherwise only says how little it knows. So does one that leads far
    away from a threshold.
    """
    if abs(by) > _reach(p, value):
        return value
    moved = p.clipped(value + by)
    gone = p.identity is not None and (moved - p.identity) * (value - p.identity) <= 0
    return value if gone else moved


def _reach(p: Parameter, value: float) -> float:
    """The longest step of a parameter that is believed."""
    return FURTHEST * abs(value) if p.inverse else np.inf


def least_error(p: Parameter, value: float, score: float) -> float:
    """Standard error below which no strength is known whose effect is seen with such a score.

    An effect that grows as the power r of its strength and is seen at z standard errors is known to
    1 / (r z) of its strength, and none here grows faster than a square. That of a threshold is
    taken as the octaves that lie above it, with which it grows as they do: how fast such an effect
    sets in is in the light. By a square errors of eight thresholds of a correction of defects
    (seeds 23 to 35 of the bench, and set 20 of the withheld effects) were 1.9 times too small.
    """
    assert p.identity is not None, "a strength has a value at which the effect vanishes"
    z = float(np.sqrt(max(score, 1.0)))
    if p.inverse and value > 0:
        return abs(value * float(np.log(value / p.identity))) / z
    return abs(value - p.identity) / (2.0 * z)
