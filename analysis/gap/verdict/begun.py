"""What the first frames of shots say, which no other statistic sees."""

from __future__ import annotations

import dataclasses

from analysis.gap.look.settling import LEFT_OUT, Beginning
from analysis.gap.report import Figure, GapReport, Named, Place
from analysis.gap.verdict.trust import LATER
from sensor.effect import Stage
from sensor.effects.image_lag import ImageLag


def with_first_frames(report: GapReport, begins: Beginning | None) -> GapReport:
    """A report with what the first frames say, where all other frames match: that charge stays
    behind, electron by electron, or that something is wrong.

    Args:
        report: by the other frames.
        begins: how shots begin, if not like they go on.
    """
    if begins is None:
        return report
    note = f"the first {LEFT_OUT} frames of each shot, which begins unlike the rest, are left out"
    report = dataclasses.replace(report, notes=(*report.notes, note))
    if report.verdict != "matched":
        return report
    named = _lag(begins)
    return dataclasses.replace(
        report,
        verdict="explained" if named else "unexplained",
        effects=named,
        gap=dataclasses.replace(report.gap, p_value_before=begins.chance),
        where=(*_places(begins), *report.where),
    )


def _lag(begins: Beginning) -> tuple[Named, ...]:
    """The image lag that first and second frames agree on, if they do."""
    if begins.share is None:
        return ()
    fraction = Figure(value=begins.share, se=begins.share_se, unit="1")
    return (
        Named(
            name=ImageLag.name,
            probability=LATER,
            indistinguishable_from=(),
            absorbed=0.0,
            parameters={"fraction": fraction},
        ),
    )


def _places(begins: Beginning) -> tuple[Place, ...]:
    """The first frame of each shot that differs, the most certain first."""
    seen = sorted(zip(begins.shots, begins.z, begins.off_dn, strict=True), key=lambda o: -abs(o[1]))
    return tuple(
        Place(
            family="frames",
            statistic="first frame",
            stage=Stage.PHOTOSITE.value,
            channel=None,
            shot=shot,
            panel=None,
            z=z,
            size=off_dn,
            unit="DN",
        )
        for shot, z, off_dn in seen
    )
