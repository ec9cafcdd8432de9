"""When frames do not show their noise: clipped, saturated, or quieter than the step of rounding."""

from __future__ import annotations

from collections.abc import Iterable

from analysis.estimators.parts.observations import Observation
from sensor.frames import Capture

CLIPPED = 0.5
"""From this share of samples at 0 on, the median itself is clipped: the spread says nothing."""

TOUCHED = 0.01
"""Share at 0 from which clipping is worth a warning: a Gaussian's SD then falls by 0.4 %."""

SATURATED = 0.001
"""Share at the top from which a panel is left out; a few stuck pixels are allowed."""

QUIET_DN = 0.5
"""Noise below which rounding depends on where the level lies between two codes."""


NO_DARKS = 'no dark frames: add a shot with light = "none"'
NO_LIGHT = "no lit panel that is neither saturated nor clipped: add lit shots of other levels"
ONE_EXPOSURE = "darks at a single exposure: add darks at a second one, to see what grows with it"


def clipped(seen: Observation) -> bool:
    """Whether half or more of the samples are 0."""
    return seen.noise.at_zero >= CLIPPED


def saturated(seen: Observation) -> bool:
    """Whether more than one sample in a thousand is at the top."""
    return seen.noise.at_top > SATURATED


def clipped_reason(darks: list[Observation]) -> str:
    """Why dark frames that are clipped at 0 cannot tell."""
    share = sum(seen.noise.at_zero for seen in darks) / len(darks)
    return (
        f"the dark frames are clipped: {100 * share:.1f} % of their samples are 0 DN, so their"
        " spread is not the noise; raise the camera's black level"
    )


def no_panels(capture: Capture) -> list[str]:
    """Say so where nobody said where to look."""
    if capture.panels:
        return []
    area = capture.areas[0]
    return [f"no panels given: the central {area.w} x {area.h} pixels were measured"]


def cautions_of(
    capture: Capture, observations: tuple[Observation, ...], *, filled_in: bool
) -> tuple[str, ...]:
    """What a careful reader must know of the frames before using the figures.

    Args:
        capture: the capture.
        observations: what was seen in its panels.
        filled_in: whether colours were filled in.
    """
    first = capture.frames[0]
    darks = [seen for seen in observations if seen.shot.dark]
    lit = [seen for seen in observations if not seen.shot.dark]
    found = no_panels(capture)
    if first.demosaiced and first.cfa is None:
        found.append(
            "nobody said how the colours were made: a bilinear demosaic was assumed"
            if filled_in
            else "nobody said how the colours were made: every pixel was measured, by its noise"
        )
    left_out = [seen for seen in lit if saturated(seen)]
    if left_out:
        found.append(f"saturated, so left out: {_places(left_out)}")
    left_out = [seen for seen in lit if clipped(seen) and not saturated(seen)]
    if left_out:
        found.append(f"clipped at 0 DN, so left out: {_places(left_out)}")
    left_out = [seen for seen in darks if clipped(seen)]
    if left_out:
        found.append(f"dark but clipped at 0 DN, so left out: {_places(left_out)}")
    touched = [seen for seen in darks if TOUCHED <= seen.noise.at_zero < CLIPPED]
    if touched:
        share = max(seen.noise.at_zero for seen in touched)
        found.append(
            f"up to {100 * share:.0f} % of dark samples are clipped at 0 DN, which makes the noise"
            f" look smaller: {_places(touched)}"
        )
    quiet = [seen for seen in darks if not clipped(seen) and seen.noise.temporal_dn < QUIET_DN]
    if quiet:
        least = min(seen.noise.temporal_dn for seen in quiet)
        found.append(
            f"dark noise of {least:.2f} DN is below half a step, where the figure depends on the"
            f" level's place between two codes: {_places(quiet)}"
        )
    if darks and len({seen.shot.exposure_s for seen in darks}) == 1:
        found.append(
            "darks at a single exposure: 'read' is their mean and holds the dark-current shot noise"
        )
    return tuple(found)


def _places(observations: Iterable[Observation]) -> str:
    return places((seen.shot.label, seen.panel, seen.channel) for seen in observations)


def places(where: Iterable[tuple[str, str, str]]) -> str:
    """Shots, each with its panels and channels: ``dark-8ms panel 19 (R, G); ...``.

    Args:
        where: label of the shot, panel and channel.
    """
    by_panel: dict[tuple[str, str], list[str]] = {}
    for label, place, channel in where:
        channels = by_panel.setdefault((label, place), [])
        if channel not in channels:
            channels.append(channel)
    by_shot: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for (shot, panel), channels in by_panel.items():
        by_shot.setdefault((shot, tuple(channels)), []).append(panel)
    return "; ".join(
        f"{shot} panel{'s' if len(panels) > 1 else ''} {', '.join(panels)} ({', '.join(channels)})"
        for (shot, channels), panels in by_shot.items()
    )
