"""What a capture shows, panel by panel: the raw material of every estimator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.estimators.parts.panel_noise import Floats, PanelNoise, combine, measure_panel
from sensor.frames import Capture, CaptureError, Frames, Panel, Shot, TooFewFrames


@dataclass(frozen=True, kw_only=True, eq=False)
class Observation:
    """The noise of one channel in one panel of one shot."""

    shot: Shot
    panel: str
    channel: str
    noise: PanelNoise


def require_pairs(capture: Capture) -> None:
    """Refuse a shot of a single frame: it has no noise in time.

    Raises:
        TooFewFrames: naming the shot.
    """
    for frames in capture.frames:
        if frames.count < 2:
            raise TooFewFrames(
                f"shot '{frames.shot.label}' has {frames.count} frame",
                "expected at least 2 in every shot, for noise in time",
                "take more frames or leave the shot out",
            )


def observe(capture: Capture) -> tuple[Observation, ...]:
    """Measure every channel of every panel of every shot.

    Raises:
        TooFewFrames: where a shot has a single frame.
        CaptureError: where a panel is too small to fit a parabola to.
    """
    require_pairs(capture)
    return tuple(
        Observation(
            shot=frames.shot,
            panel=panel.name,
            channel=channel,
            noise=_measure(frames, panel, channel),
        )
        for frames in capture.frames
        for panel in capture.areas
        for channel in frames.channels
    )


def _measure(frames: Frames, panel: Panel, channel: str) -> PanelNoise:
    try:
        return combine(
            tuple(
                measure_panel(lattice, frames.top_dn) for lattice in frames.lattices(panel, channel)
            )
        )
    except TooFewFrames:
        raise
    except CaptureError as error:
        raise CaptureError(
            f"panel '{panel.name}': {error.found}", error.expected, error.remedy
        ) from error


def pattern_covariance(observations: list[Observation], se: Floats) -> Floats:
    """Covariance of spatial noise figures whose standard errors are given.

    Shots of one panel see the same pixels, so their errors are shared as far as their fixed
    patterns are: two sample variances of Gaussian patterns correlate by the square of the
    patterns' correlation. Different panels are independent.
    """
    covariance = np.diag(se**2)
    for panel in {observation.panel for observation in observations}:
        at = [i for i, observation in enumerate(observations) if observation.panel == panel]
        maps = np.stack([observations[i].noise.residual_dn for i in at])
        length = np.linalg.norm(maps, axis=1, keepdims=True)
        unit = np.divide(maps, length, out=np.zeros_like(maps), where=length > 0)
        shared = np.square(unit @ unit.T)
        np.fill_diagonal(shared, 1.0)
        covariance[np.ix_(at, at)] = shared * np.outer(se[at], se[at])
    return covariance
