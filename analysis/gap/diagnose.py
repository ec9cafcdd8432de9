"""The whole diagnosis: calibrate, measure the gap, ask every suspect, and say what may be said."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.attribute import Candidate, Case, attribute
from analysis.gap.base import Body, camera_of
from analysis.gap.calibrate import black_of, first_guess
from analysis.gap.distance import Distance, Yardstick, distance, yardstick
from analysis.gap.fit import Fit, around, refine
from analysis.gap.hints import Hints, brightest, period_px
from analysis.gap.lattices import BORDER_PX, lattices_of
from analysis.gap.light import light_of
from analysis.gap.observe import BLOCKS_DOWN, IMAGE, STAGES, Observation, View, observe
from analysis.gap.report import (
    NO_GAP,
    Figure,
    Gap,
    GapReport,
    Named,
    Place,
    Suspect,
)
from analysis.gap.shots import FEWEST_FRAMES, FEWEST_SHOTS, GROUP_FRAMES, Plan, groups_of, plan
from analysis.gap.texture import STAGE as TEXTURE_STAGE
from analysis.gap.twin import Scenery, exposure_of, shots_of
from analysis.gap.verdict import (
    EQUIVALENT,
    LEAST_SHRINK,
    SIGNIFICANCE,
    Choice,
    both,
    choose,
    next_capture,
    p_of_best,
    probabilities,
    verdict,
)
from render.rate import RateImage
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect, Parameter
from sensor.frames import Capture

Floats = NDArray[np.float64]
Watch = Callable[[str], None]

MOST_EFFECTS = 3
PLACES = 12


@dataclass(frozen=True, kw_only=True, eq=False)
class Setting:
    """A capture made ready: its plan, its light, and what was seen of its key shots."""

    capture: Capture
    plan: Plan
    scenery: Scenery
    seen: Observation
    black_dn: float


def look(capture: Capture, stated: Mapping[str, RateImage]) -> Setting | None:
    """Everything that is known of a capture before any model; None where it has too few frames."""
    chosen = plan(capture)
    if chosen is None:
        return None
    lattices = lattices_of(capture)
    first = capture.frames[0]
    down = (min(first.height, first.width * 3 // 4) - 2 * BORDER_PX) // lattices[0].step
    view = View(
        lattices=lattices,
        frames=chosen.frames,
        side=max(1, -(-down // BLOCKS_DOWN)),
        top_dn=first.top_dn,
    )
    keys = [f for f in capture.frames if f.shot.label in chosen.key]
    black_dn = _black(capture)
    cfa = first.cfa or _cfa(lattices)
    scenery = Scenery(
        body=Body.of(first, cfa, capture.camera),
        light=light_of(capture, stated, black_dn),
        shots=shots_of([f.shot for f in keys]),
        view=view,
    )
    stacks = ((f.shot.label, not f.shot.dark, groups_of(f, chosen)) for f in keys)
    return Setting(
        capture=capture,
        plan=chosen,
        scenery=scenery,
        seen=observe(stacks, view),
        black_dn=black_dn,
    )


def _black(capture: Capture) -> float:
    darks = {f.shot.exposure_s: float(np.mean(f.dn[:4])) for f in capture.darks}
    lit: dict[float, list[float]] = {}
    for f in capture.lit:
        lit.setdefault(exposure_of(f.shot), []).append(float(np.mean(f.dn[:4])))
    return black_of(darks, lit)


def _cfa(lattices: Sequence[object]) -> str:
    names = [lattice.channel for lattice in lattices]  # type: ignore[attr-defined]
    return "".join(names) if len(names) == 4 else "GGGG" if names == ["Y"] else "RGGB"


def halves(seen: Observation) -> tuple[Observation, Observation]:
    """The groups that fit, and those that score: every other one."""
    return _part(seen, slice(0, None, 2)), _part(seen, slice(1, None, 2))


def _part(seen: Observation, groups: slice) -> Observation:
    return dataclasses.replace(seen, figures=seen.figures[groups], means=seen.means[groups])


def case_of(known: Fit, seen: Observation) -> Case:
    """A capture against a model."""
    fit_half, score_half = (known.textured(half) for half in halves(seen))
    fitting, scoring = yardstick(known, fit_half), yardstick(known, score_half)
    gap = fitting.turned.space.of(fit_half, slice(None))
    return Case(
        known=known,
        fitting=fitting,
        scoring=scoring,
        fit_seen=fit_half,
        fit_gap=gap,
        fit_left=fitting.turned.left(gap),
        score_left=scoring.turned.left(scoring.turned.space.of(score_half, slice(None))),
        groups=(fit_half.groups, score_half.groups),
    )


def calibrated(setting: Setting, nominal: Camera | None) -> Fit:
    """The base camera of a capture, from the frames that fit."""
    fit_half, _ = halves(setting.seen)
    start = first_guess(fit_half, setting.scenery, nominal, setting.black_dn)
    effects = tuple(e for e in nominal.effects if not e.base) if nominal is not None else ()
    base = refine(start, fit_half, setting.scenery, effects)
    return around(base, setting.scenery, fit_half.groups, effects)


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """A capture's distance from a model: of all its key frames, and of those that score.

    `tuned` is by how much the parameters of the model's effects should still move.
    """

    whole: Distance
    rod: Yardstick
    left: Floats
    held: Distance
    case: Case
    tuned: dict[tuple[str, str], float]


def measured(known: Fit, seen: Observation) -> Measured:
    """Distance of what was seen of the key shots."""
    textured = known.textured(seen)
    rod = yardstick(known, textured)
    gap = rod.turned.space.of(textured, slice(None))
    left = rod.turned.left(gap)
    case = case_of(known, seen)
    amounts = rod.turned.amounts(gap)[len(known.ways.knobs) :]
    return Measured(
        tuned=dict(zip(known.ways.tuned, map(float, amounts), strict=False)),
        whole=distance(left, rod),
        rod=rod,
        left=left,
        held=distance(case.score_left, case.scoring),
        case=case,
    )


def hints_of(setting: Setting, case: Case) -> Hints:
    """Where searches for a period and a place should begin."""
    space = case.fitting.turned.space
    count, size = len(space.keys), int(np.prod(space.shape))
    image = case.fit_left[count : count + size].reshape(space.shape)
    across, below = brightest(image, setting.seen.grid)
    stacks = [f for f in setting.capture.frames if f.shot.label in setting.plan.key]
    return {
        "across": across,
        "below": below,
        "period_px": period_px(stacks, setting.scenery.view.lattices),
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """Everything that a diagnosis found, for those who want more than the report.

    Attributes:
        report: what may be said.
        setting: the capture, its plan and its light; None where it has too few frames.
        models: the base, and the base with each effect that was added.
        measured: the capture's distance from each of them.
        choices: what was named, in the order it was added.
    """

    report: GapReport
    setting: Setting | None
    models: tuple[Fit, ...] = ()
    measured: tuple[Measured, ...] = ()
    choices: tuple[Choice, ...] = ()

    @property
    def camera(self) -> Camera | None:
        """The camera with everything that was found, in the units of its own light."""
        if not self.models:
            return None
        last = self.models[-1]
        made = camera_of(last.base, last.scenery.body).plus(*last.effects)
        if not last.base.level or not last.scenery.light.known:
            return made
        level = np.mean(list(last.base.level.values()), axis=0)
        level = np.repeat(level, 3) if len(level) == 1 else level
        sensitivity = Colours(R=float(level[0]), G=float(level[1]), B=float(level[2]))
        return dataclasses.replace(made, sensitivity=sensitivity)


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
    trouble = _too_little(capture)
    setting = None if trouble else look(capture, stated or {})
    if setting is None:
        trouble = trouble or (
            f"fewer than {FEWEST_SHOTS} shots have {FEWEST_FRAMES} frames; {2 * GROUP_FRAMES} of"
            " each are needed to split them into frames that fit and frames that score"
        )
        report = GapReport(
            verdict="insufficient data",
            gap=NO_GAP,
            next_capture=f"darks and lit shots of {2 * GROUP_FRAMES} or more frames, not saturated",
            seconds=time.monotonic() - began,
            notes=(trouble,),
        )
        return Diagnosis(report=report, setting=None)
    watch("calibrating the base camera")
    known = calibrated(setting, model)
    kinds = [k for k in (catalogue().values() if suspects is None else suspects) if not k.base]
    kinds = [k for k in kinds if k not in {type(e) for e in known.effects}]
    models, distances = [known], [measured(known, setting.seen)]
    choices: list[Choice] = []
    first: list[Candidate] = []
    chances: list[float] = []
    while True:
        now = distances[-1]
        left = [k for k in kinds if k not in {type(e) for e in models[-1].effects}]
        candidates = attribute(
            now.case, left, hints_of(setting, now.case), lambda name: watch(f"suspect {name}")
        )
        first = first or candidates
        chances.append(both(now.whole.p_value, p_of_best(candidates)))
        choice = choose(candidates) if chances[-1] < SIGNIFICANCE else None
        if choice is None:
            break
        later = len(choices) > 0
        if later and not _deserves(choice.best, choices[0].best):
            break
        watch(f"confirming {choice.best.name}")
        added = around(
            choice.best.base,
            setting.scenery,
            setting.seen.groups // 2 + 1,
            (*models[-1].effects, choice.best.effect),
        )
        further = measured(added, setting.seen)
        if choices and further.held.total > 0.9 * now.held.total:
            break
        models.append(added)
        distances.append(further)
        fits = further.whole.p_value >= SIGNIFICANCE
        choices.append(choose(candidates, fits) or choice)
        closed = further.held.total < LITTLE * distances[0].held.total
        if fits or closed or len(choices) == MOST_EFFECTS:
            chances.append(further.whole.p_value)
            break
    report = conclude(setting, models, distances, choices, first, chances)
    report = dataclasses.replace(report, seconds=time.monotonic() - began)
    return Diagnosis(
        report=report,
        setting=setting,
        models=tuple(models),
        measured=tuple(distances),
        choices=tuple(choices),
    )


LITTLE = 0.05
"""Part of the gap that is left to chance and to the model's own errors: no one else is blamed."""

LEAST_OF_A_LATER = 25.0
"""Score of an effect that is added to another one: what is left of a gap is easily blamed."""

PART_OF_THE_FIRST = 0.02
"""The same, as a part of the first one's score: a model that is right to a tenth leaves a hundredth
of chi-squared to whoever comes next."""


def _deserves(later: Candidate, first: Candidate) -> bool:
    """Whether an effect is to be added to another one."""
    least = max(LEAST_OF_A_LATER, PART_OF_THE_FIRST * first.score)
    return later.score > least and later.absorbed < EQUIVALENT


def _too_little(capture: Capture) -> str | None:
    """What makes a capture useless; None where nothing does."""
    lit = capture.lit
    if lit and all(float((f.dn[0] >= f.top_dn).mean()) > 0.5 for f in lit):
        return "every lit shot is saturated in more than half of its pixels"
    first = [np.asarray(f.dn[: min(2, f.count)]) for f in capture.frames]
    if all(int(np.ptp(dn)) == 0 for dn in first):
        return "all frames are of one value: there is neither a picture nor noise in them"
    if lit and all(int(dn.max()) == 0 for f, dn in zip(capture.frames, first, strict=True)
                   if not f.shot.dark):  # fmt: skip
        return "every lit shot is black"
    return None


def conclude(
    setting: Setting,
    models: Sequence[Fit],
    distances: Sequence[Measured],
    choices: Sequence[Choice],
    candidates: Sequence[Candidate],
    chances: Sequence[float],
) -> GapReport:
    """The report of what was found."""
    before, after = distances[0], distances[-1]
    gap = gap_of(before, after, chances[0], chances[-1], candidates, choices)
    word = verdict(len(choices), chances[0], chances[-1], gap.shrink, gap.at_floor)
    if word == "unexplained":
        gap = gap_of(before, before, chances[0], chances[0], candidates, ())
        choices = ()
    weights = choices[0].by_name if choices else probabilities(candidates)
    doubt = 1.0 if choices or not candidates else 0.45
    named = tuple(_named(choice, word, gap, models[-1], after) for choice in choices)
    confused = [n for entry in named for n in (entry.name, *entry.indistinguishable_from)
                if entry.indistinguishable_from]  # fmt: skip
    wanted = next_capture(confused) if confused else None
    if word == "unexplained":
        wanted = next_capture([c.name for c in candidates[:2]])
    total = float(before.case.scoring.expected.sum())
    return GapReport(
        verdict=word,
        effects=named,
        candidates=tuple(
            Suspect(
                name=c.name,
                probability=float(weights.get(c.name, 0.0)) * doubt,
                gap=before.held.total - c.forward / total,
                calibration_equivalent=c.absorbed > EQUIVALENT,
                score=c.score,
            )
            for c in candidates
        ),
        gap=gap,
        where=places(before, setting),
        next_capture=wanted,
        calibration=calibration_figures(
            models[-1] if choices else models[0], after.rod if choices else before.rod
        ),
        notes=notes_of(setting),
    )


def _named(choice: Choice, word: str, gap: Gap, model: Fit, found: Measured) -> Named:
    best = choice.best
    effect = next(e for e in model.effects if e.name == best.name)
    trust = 1.0
    if word != "explained" and not gap.at_floor:
        trust = 0.4 + 0.6 * float(np.clip((gap.shrink - LEAST_SHRINK) / (1 - LEAST_SHRINK), 0, 1))
    return Named(
        name=best.name,
        probability=min(0.99, choice.probability * trust),
        indistinguishable_from=tuple(c.name for c in choice.alike),
        absorbed=best.absorbed,
        parameters={p.name: _parameter(effect, p, best, model, found) for p in effect.parameters()},
    )


def _parameter(
    effect: Effect, p: Parameter, best: Candidate, model: Fit, found: Measured
) -> Figure:
    """A parameter after the last step of the fit, with its standard error where it has one."""
    value = float(Colours.of(getattr(effect, p.name)).G)
    key = (effect.name, p.name)
    if key not in found.tuned:
        return Figure(value=value, se=best.errors.get(p.name), unit=p.unit)
    moved = float(np.clip(value + found.tuned[key], p.minimum, p.maximum))
    place = len(model.ways.knobs) + model.ways.tuned.index(key)
    return Figure(value=moved, se=float(found.rod.errors[place]), unit=p.unit)


def gap_of(
    before: Measured,
    after: Measured,
    p_before: float,
    p_after: float,
    candidates: Sequence[Candidate],
    choices: Sequence[Choice],
) -> Gap:
    """Distances on the frames that score, and how much of them the added effects close."""
    floor = 0.0
    b, a = before.held.total, after.held.total
    se_before, se_after = _error(before), _error(after)
    span = b - floor
    shrink = (b - a) / span if span != 0 else 0.0
    error = float(np.hypot(se_after, se_before * a / span) / abs(span)) if span != 0 else 0.0
    rod = before.case.scoring
    total = float(rod.expected.sum())
    named = {c.best.name for c in choices} | {x.name for c in choices for x in c.alike}
    wrong = [c.forward / total / span for c in candidates if c.name not in named and span > 0]
    families = {
        name: {
            "before": before.held.by_family[name],
            "after": after.held.by_family.get(name, 0.0),
            "p_value": before.whole.p_by_family[name],
        }
        for name in before.held.by_family
    }
    worse = {n: f["after"] - f["before"] for n, f in families.items()}
    harmed = max(worse, key=lambda n: worse[n]) if choices else None
    if harmed is not None and after.whole.p_by_family.get(harmed, 1.0) > SIGNIFICANCE / 10:
        harmed = None
    return Gap(
        before=b,
        after=a,
        floor=floor,
        shrink=shrink,
        shrink_ci=(shrink - 1.96 * error, shrink + 1.96 * error),
        at_floor=bool(span < 2 * np.hypot(se_before, se_after)),
        p_value_before=p_before,
        p_value_after=p_after,
        by_family=families,
        harmed=harmed,
        placebo=float(np.median(wrong)) if wrong else 0.0,
    )


def _error(found: Measured) -> float:
    rod = found.case.scoring
    return float(np.sqrt(rod.variance.sum()) / rod.expected.sum())


def places(found: Measured, setting: Setting) -> tuple[Place, ...]:
    """Where the capture differs most from the base, one entry for each kind of difference."""
    space = found.rod.turned.space
    count = len(space.keys)
    raw = found.left[:count] * space.spread
    made = []
    for index in np.argsort(-np.abs(found.left[:count])):
        key = space.keys[index]
        made.append(
            Place(
                family=key.family,
                statistic=key.statistic,
                stage=STAGES.get(key.family, TEXTURE_STAGE),
                channel=None if key.lattice == "all" else key.lattice[0],
                shot=key.shot,
                panel=None,
                z=float(found.left[index]),
                size=float(raw[index]),
                unit="DN" if key.statistic == "dark level" else "1",
            )
        )
    made += image_places(found, setting)
    made.sort(key=lambda place: -abs(place.z))
    kinds: dict[tuple[str, str], Place] = {}
    for place in made:
        kinds.setdefault((place.family, place.statistic), place)
    return tuple(kinds.values())[:PLACES]


def image_places(found: Measured, setting: Setting) -> list[Place]:
    """The panels, or quarters of the image, whose mean is most off."""
    space = found.rod.turned.space
    count, size = len(space.keys), int(np.prod(space.shape))
    left = found.left[count : count + size].reshape(space.shape)
    down, across = setting.seen.grid
    spread = 1.0 / np.maximum(np.abs(space.whitening[..., range(space.shape[0]),
                                                     range(space.shape[0])]), 1e-9)  # fmt: skip
    height, width = setting.scenery.body.height, setting.scenery.body.width
    areas: list[tuple[str | None, slice, slice]] = [
        (
            p.name,
            _span(p.y * down / height, (p.y + p.h) * down / height),
            _span(p.x * across / width, (p.x + p.w) * across / width),
        )
        for p in (setting.scenery.light.panels or setting.capture.panels)
    ]
    areas = areas or [(None, slice(0, down), slice(0, across))]
    made = []
    for s, shot in enumerate(setting.scenery.shots):
        for c, channel in enumerate(setting.seen.channels):
            image = left[s, c].reshape(down, across)
            errors = spread[c, :, s].reshape(down, across)
            for name, rows, columns in areas:
                part = image[rows, columns]
                if part.size == 0:
                    continue
                made.append(
                    Place(
                        family=IMAGE,
                        statistic="mean of a panel",
                        stage=STAGES[IMAGE],
                        channel=channel,
                        shot=shot.label,
                        panel=name,
                        z=float(part.sum() / np.sqrt(part.size)),
                        size=float((part * errors[rows, columns]).mean()),
                        unit="DN",
                    )
                )
    return made


def _span(first: float, last: float) -> slice:
    """Whole blocks from the one that holds the first point."""
    return slice(int(first), max(int(first) + 1, int(last)))


UNITS = {"gain": "DN/e-", "read": "DN", "fpn": "DN", "prnu": "1"}


def calibration_figures(known: Fit, rod: Yardstick) -> dict[str, dict[str, Figure]]:
    """The base camera by figure and channel, with standard errors."""
    base, found = known.base, {}
    names = [(knob.name, knob.channel) for knob in known.ways.knobs]
    errors = dict(zip(names, map(float, rod.errors), strict=False))
    for name, values in (
        ("gain", base.gain_dn_per_e),
        ("read", np.sqrt(base.read_dn2)),
        ("fpn", np.sqrt(base.fpn_dn2)),
        ("prnu", np.sqrt(base.prnu2)),
    ):
        table = {}
        for c, channel in enumerate(base.channels):
            error = errors.get((name, c))
            value = float(values[c])
            if error is not None:
                # of a logarithm, or of a variance
                error = error * value if name == "gain" else error / (2 * max(value, 1e-6))
            table[channel] = Figure(value=value, se=error, unit=UNITS[name])
        found[name] = table
    black = Figure(value=base.black_dn, se=errors.get(("black", None)), unit="DN")
    dark = Figure(value=base.dark_e_per_s, se=errors.get(("dark", None)), unit="e-/s")
    return {**found, "black": {"all": black}, "dark_current": {"all": dark}}


def notes_of(setting: Setting) -> tuple[str, ...]:
    """What a reader must know of how the capture was used."""
    notes = [f"light: {setting.scenery.light.source}"]
    if not setting.scenery.light.known and setting.capture.lit:
        notes.append("the picture itself is not judged, only what differs between shots of a lamp")
    if setting.plan.unused:
        notes.append(f"too few frames to be used: {', '.join(setting.plan.unused)}")
    return tuple(notes)
