"""What the first frames of shots say, which no other statistic sees."""

from __future__ import annotations

import dataclasses

from analysis.gap.look.first_frames import LEFT_OUT, Beginning
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
    lag = lag_of(begins)
    return dataclasses.replace(
        report,
        verdict="explained" if lag else "unexplained",
        effects=(_named(lag, begins),) if lag else (),
        gap=dataclasses.replace(report.gap, p_value_before=begins.chance),
        where=(*_places(begins), *report.where),
    )


def lag_of(begins: Beginning | None) -> ImageLag | None:
    """The image lag that first and second frames agree on, if they do: of single electrons, as one
    of a fixed share is seen in all frames.
    """
    if begins is None or begins.share is None:
        return None
    return ImageLag(fraction=begins.share, by_chance=1.0, from_dark=float(begins.from_dark))


def _named(lag: ImageLag, begins: Beginning) -> Named:
    errors = {"fraction": begins.share_se}
    return Named(
        name=lag.name,
        probability=LATER,
        indistinguishable_from=(),
        absorbed=0.0,
        parameters={
            p.name: Figure(value=getattr(lag, p.name), se=errors.get(p.name), unit=p.unit)
            for p in lag.parameters()
        },
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
