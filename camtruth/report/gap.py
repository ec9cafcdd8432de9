"""The page of `camtruth diagnose`: where the gap lies, what causes it, how far it shrinks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.fit import Fit
from analysis.gap.camera.twin import electrons
from analysis.gap.diagnose import Diagnosis
from analysis.gap.look.families import EVERY_SHOT, STAGES
from analysis.gap.report import Figure, GapReport, Named, Place
from analysis.gap.search.choice import LEAST_SCORE, MARGIN, MARGIN_OF_SCORE
from camtruth.report.pictures import data_url
from camtruth.report.plot import Axis, Marks, axis_over, plot
from camtruth.report.sections import Section, Table, sections_page
from camtruth.terminal import with_error
from render.preview import srgb
from sensor.effect import Stage
from sensor.frames import Frames
from sensor.simulation import pixels_of, simulate

MOST_SUSPECTS = 10
SHOWN_SIGMA = 4.0
"""Differences of mean images are shown up to so many standard deviations of their noise."""


def answer(report: GapReport) -> str:
    """The answer in one paragraph."""
    gap = report.gap
    match report.verdict:
        case "insufficient data":
            return f"Insufficient data: {'; '.join(report.notes)}. Capture {report.next_capture}."
        case "matched":
            return (
                "Matched: after calibration these frames do not differ from the simulated camera's"
                f" by more than chance (p = {gap.p_value_before:.2g})."
            )
        case "unexplained":
            place = report.where[0]
            nearest = next((c.name for c in report.candidates), None)
            near = f" The nearest known effect is {nearest}." if nearest else ""
            return (
                f"Unexplained: there is a gap (p = {gap.p_value_before:.2g}), largest in"
                f" {_words(place)}, and no known effect, nor"
                f" several, accounts for it.{near} Next capture: {report.next_capture}."
            )
    names = " and ".join(_with_parameters(e) for e in report.effects)
    text = f"{report.verdict.capitalize()}: {names}."
    for e in report.effects:
        if e.indistinguishable_from:
            text += (
                f" These frames do not tell {e.name} from {' or '.join(e.indistinguishable_from)}."
            )
    if gap.at_floor:
        text += " The gap is near its floor, where its shrink cannot be measured."
    else:
        low, high = gap.shrink_ci
        text += (
            f" On the half of the frames that did not fit it the gap shrinks by {gap.shrink:.0%}"
            f" ({low:.0%} to {high:.0%})."
        )
    if report.verdict == "partly explained":
        text += f" Something is left (p = {gap.p_value_after:.2g})."
    if report.next_capture:
        text += f" To tell them apart, capture {report.next_capture}."
    return text


def _words(place: Place) -> str:
    """A place in words, with the stage where gaps of its kind most often begin."""
    shot = place.shot if place.shot == EVERY_SHOT else f"shot {place.shot}"
    channel = f", {place.channel}" if place.channel else ""
    return f"“{place.statistic}” of {shot}{channel} ({place.stage})"


def _with_parameters(effect: Named) -> str:
    told = [
        f"{name} {_figure(value)}"
        for name, value in effect.parameters.items()
        if value.se is not None and value.se > 0
    ]
    sure = f"probability {effect.probability:.2f}"
    return f"{effect.name} ({'; '.join([*told, sure])})"


def _figure(value: Figure) -> str:
    unit = "" if value.unit == "1" else f" {value.unit}"
    return with_error(value.value, value.se) + unit


def page(found: Diagnosis, command: str) -> str:
    """The page as HTML."""
    report = found.report
    sections: list[Section] = []
    if found.setting is not None:
        sections = [
            _where(report),
            _families(report),
            _suspects(report),
            _pictures(found),
            _calibration(report),
        ]
    return sections_page(
        title="Real against simulated",
        lead=answer(report),
        command=command,
        sections=[s for s in sections if s is not None],
    )


def _where(report: GapReport) -> Section:
    rows = [
        (
            p.stage,
            p.family,
            p.statistic,
            p.shot,
            p.channel or "",
            p.panel or "",
            f"{p.z:+.1f}",
            f"{p.size:+.3g}",
            "" if p.unit == "1" else p.unit,
        )
        for p in report.where
    ]
    heads = ("stage", "family", "what", "shot", "channel", "panel", "z", "size", "unit")
    by_stage = {stage.value: 0.0 for stage in Stage}
    for p in report.where:
        by_stage[p.stage] = max(by_stage[p.stage], abs(p.z))
    return Section(
        title="Where",
        text=(
            "The largest differences from the calibrated base camera, one line for each kind, in"
            " standard errors and in their own size.",
        ),
        svgs=[_bars("Largest |z| by stage of the signal path", by_stage, "standard errors")],
        caption="Each stage is that where a difference of this kind most often begins.",
        tables=[Table(heads=heads, rows=rows)],
    )


def _families(report: GapReport) -> Section:
    rows = [
        (name, STAGES[name], f"{f['before']:.3f}", f"{f['after']:.3f}",
         f"{f['p_value']:.2g}")
        for name, f in report.gap.by_family.items()
    ]  # fmt: skip
    gap = report.gap
    lead = (
        f"G is 0 on average where nothing is wrong. In all: {gap.before:.3f} before,"
        f" {gap.after:.3f} after; global p-value {gap.p_value_before:.2g} before,"
        f" {gap.p_value_after:.2g} after. Wrong effects close {gap.placebo:.0%} of it (placebo)."
    )
    harmed = f" Made worse: {gap.harmed}." if gap.harmed else ""
    return Section(
        title="How far",
        text=(lead + harmed,),
        tables=[Table(heads=("family", "stage", "G before", "G after", "p before"), rows=rows)],
    )


def _suspects(report: GapReport) -> Section:
    rows = [
        (
            c.name,
            f"{c.score:.1f}",
            f"{c.probability:.3f}",
            f"{c.gap:.3f}",
            "calibration takes it up" if c.calibration_equivalent else "",
        )
        for c in report.candidates[:MOST_SUSPECTS]
    ]
    scores = {c.name: max(c.score, 0.0) for c in report.candidates[:MOST_SUSPECTS]}
    return Section(
        title="Which",
        text=(
            "Every effect of the catalogue, fitted together with the base on one half of the"
            " frames and scored on the other. The score is the fall of chi-squared; a suspect that"
            f" is named needs {LEAST_SCORE:g}, and {MARGIN:g} or {100 * MARGIN_OF_SCORE:g} % of it"
            " more than any that is not named with it.",
        ),
        svgs=[_bars("Score of the best suspects", scores, "fall of chi-squared")],
        caption="Fitted on one half of the frames, scored on the other, both ways.",
        tables=[Table(heads=("suspect", "score", "probability", "gap with it", ""), rows=rows)],
    )


def _bars(title: str, values: dict[str, float], label: str) -> str:
    """Horizontal bars, one for each name."""
    top = max([*values.values(), 1e-9])
    lines = [
        f'<svg class="plot narrow" viewBox="0 0 460 {30 + 18 * len(values)}" role="img"'
        f' aria-label="{title}">',
        f'<text class="title" x="8" y="14">{title}</text>',
        f"<desc>{label}</desc>",
    ]
    for k, (name, value) in enumerate(values.items()):
        y = 32 + 18 * k
        width = 200 * value / top
        lines.append(f'<text class="label" x="176" y="{y + 4}" text-anchor="end">{name}</text>')
        lines.append(
            f'<rect class="dots b" x="182" y="{y - 6}" width="{width:.1f}" height="12" rx="1"/>'
        )
        lines.append(f'<text class="tick" x="{188 + width:.1f}" y="{y + 4}">{value:,.1f}</text>')
    return "\n".join([*lines, "</svg>"])


def _pictures(found: Diagnosis) -> Section:
    """Real, simulated, and their difference; and the spectrum of the noise along the rows."""
    assert found.setting is not None
    assert found.trail is not None
    report, models = found.report, found.trail.models
    key = found.setting.plan.key
    label = next((p.shot for p in report.where if p.shot in key), key[0])
    real = next(f for f in found.setting.capture.frames if f.shot.label == label)
    frames = found.setting.plan.frames
    before = _simulated(models[0], label, frames)
    after = _simulated(models[-1], label, frames)
    taken = np.asarray(real.dn[:frames])
    top = max(float(np.percentile(taken[0], 99.9)), 1.0)
    cells = [
        ("real", _shown(taken[0], top)),
        ("simulated, base", _shown(before[0], top)),
        ("difference of means, base", _difference(taken, before)),
    ]
    if len(models) > 1:
        cells += [
            ("simulated, with the effect", _shown(after[0], top)),
            ("difference of means, with it", _difference(taken, after)),
        ]
    body = "".join(
        f'<figure class="picture"><img alt="{text}" src="{data_url(image)}">'
        f"<figcaption>{text}</figcaption></figure>"
        for text, image in cells
    )
    return Section(
        title="To look at",
        text=(
            f"Shot {label}: first frames, and differences of the means of {frames} frames, shown"
            f" up to {SHOWN_SIGMA:g} standard deviations either side of grey.",
        ),
        interactive=f'<div class="pictures three pixels">{body}</div>',
        svgs=[_spectra(real, taken, before, after if len(models) > 1 else None)],
        caption="Power of the green channel's noise along the rows: dots the real frames, blue the"
        " base, red with the effect.",
    )


def _simulated(model: Fit, label: str, count: int) -> NDArray[np.generic]:
    from analysis.gap.camera.base import camera_of

    scenery = model.scenery
    shot = next(s for s in scenery.shots if s.label == label)
    camera = camera_of(model.base, scenery.body).plus(*model.effects)
    lit = electrons(scenery.light, model.base.blur, model.base.level)
    return pixels_of(camera, simulate(camera, shot, lit, frames=range(count)))


def _shown(frame: NDArray[np.generic], top: float) -> NDArray[np.uint8]:
    return srgb(_coloured(frame) / top)


def _coloured(frame: NDArray[np.generic]) -> NDArray[np.float64]:
    values = frame.astype(np.float64)
    return values if values.ndim == 3 else np.repeat(values[..., None], 3, axis=2)


def _difference(real: NDArray[np.generic], other: NDArray[np.generic]) -> NDArray[np.uint8]:
    change = _coloured(real.mean(axis=0) - other.mean(axis=0))
    noise = float(real.astype(np.float32).std(axis=0, ddof=1).mean()) / np.sqrt(len(real)) + 0.05
    grey = 127.5 + 127.5 * np.clip(change / (SHOWN_SIGMA * noise), -1, 1)
    return np.asarray(grey, dtype=np.uint8)


def _spectra(
    real: Frames,
    taken: NDArray[np.generic],
    before: NDArray[np.generic],
    after: NDArray[np.generic] | None,
) -> str:
    def spectrum(stack: NDArray[np.generic]) -> NDArray[np.float64]:
        plane = stack[..., 1] if stack.ndim == 4 else stack
        noise = plane.astype(np.float64) - plane.mean(axis=0)
        power = np.square(np.abs(np.fft.rfft(noise, axis=2))).mean(axis=(0, 1)) / noise.shape[2]
        edges = np.unique(np.geomspace(1, len(power) - 1, 40).astype(int))
        return np.array([power[a:b].mean() for a, b in pairwise(edges)])

    width = taken.shape[2]
    edges = np.unique(np.geomspace(1, width // 2, 40).astype(int))
    x = np.log10(np.sqrt(edges[:-1] * edges[1:]) / width)
    seen = spectrum(taken)
    marks = [Marks(x=x[: len(seen)].tolist(), y=seen.tolist(), style="k")]
    base = spectrum(before)
    marks.append(Marks(x=x[: len(base)].tolist(), y=base.tolist(), style="b", kind="line"))
    every: Sequence[float] = [*seen.tolist(), *base.tolist()]
    if after is not None:
        found = spectrum(after)
        marks.append(Marks(x=x[: len(found)].tolist(), y=found.tolist(), style="r", kind="line"))
        every = [*every, *found.tolist()]
    across = Axis(low=float(x.min()) - 0.1, high=float(x.max()) + 0.1,
                  label="log10 of cycles per pixel")  # fmt: skip
    return plot("Noise along the rows", across, axis_over(list(every), "DN²"), marks)


def _calibration(report: GapReport) -> Section:
    rows = []
    for name, table in report.calibration.items():
        for channel, value in table.items():
            rows.append(
                (name, "" if channel == "all" else channel, with_error(value.value, value.se),
                 "" if value.unit == "1" else value.unit)
            )  # fmt: skip
    return Section(
        title="The calibrated camera",
        text=tuple(note[:1].upper() + note[1:] + "." for note in report.notes),
        tables=[Table(heads=("figure", "channel", "value", "unit"), rows=rows)],
    )
