"""The answer as data: what `gap.json` holds, whoever writes or scores it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

FORMAT = "camtruth-gap/1"

Verdict = Literal["matched", "explained", "partly explained", "unexplained", "insufficient data"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)

EQUIVALENT = 0.9
"""Part of a signature that calibration takes up, from which an effect counts as calibrated."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A figure with its standard error; None where it was not fitted."""

    value: float
    se: float | None
    unit: str


@dataclass(frozen=True, kw_only=True)
class Named:
    """An effect that was added to the camera.

    Attributes:
        name: of the effect.
        probability: that it is this one.
        indistinguishable_from: at most two that these frames cannot tell from it.
        absorbed: part of its signature that calibration takes up.
        parameters: as fitted.
    """

    name: str
    probability: float
    indistinguishable_from: tuple[str, ...]
    absorbed: float
    parameters: dict[str, Figure]


@dataclass(frozen=True, kw_only=True)
class Suspect:
    """A suspect and what became of it.

    Attributes:
        name: of the effect.
        probability: that it is this one.
        gap: what would be left of the gap with it.
        calibration_equivalent: whether calibration takes up more than `EQUIVALENT` of it.
        score: fall of chi-squared on frames that did not fit it.
    """

    name: str
    probability: float
    gap: float
    calibration_equivalent: bool
    score: float


@dataclass(frozen=True, kw_only=True)
class Gap:
    """How far real and simulated frames are apart, before and after the effects were added."""

    before: float
    after: float
    floor: float
    shrink: float
    shrink_ci: tuple[float, float]
    at_floor: bool
    p_value_before: float
    p_value_after: float
    by_family: dict[str, dict[str, float]]
    harmed: str | None
    placebo: float


@dataclass(frozen=True, kw_only=True)
class Place:
    """One place where real and simulated frames differ; z is in standard errors, size in `unit`.

    The error of a statistic has 5 % of its difference in it (`calibrate.space.MODEL_ERROR`), so
    that its z saturates near 20; that of the mean of a panel and of a first frame does not.
    """

    family: str
    statistic: str
    stage: str
    channel: str | None
    shot: str
    panel: str | None
    z: float
    size: float
    unit: str


@dataclass(frozen=True, kw_only=True)
class GapReport:
    """What a diagnosis says.

    Attributes:
        verdict: one of `VERDICTS`.
        effects: what was added, strongest first.
        candidates: all suspects, best first.
        gap: before and after.
        where: the places that differ most, strongest first.
        next_capture: what would separate what these frames cannot; None when not needed.
        seconds: it took.
        calibration: the base camera by figure and channel.
        notes: what a reader must know besides.
    """

    verdict: Verdict
    effects: tuple[Named, ...] = ()
    candidates: tuple[Suspect, ...] = ()
    gap: Gap
    where: tuple[Place, ...] = ()
    next_capture: str | None = None
    seconds: float = 0.0
    calibration: dict[str, dict[str, Figure]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """As `gap.json` spells it; figures that are not finite become null."""
        return {"format": FORMAT, **_plain(dataclasses.asdict(self))}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if isinstance(value, bool) or value is None or isinstance(value, (str, int)):
        return value
    number = float(value)
    return number if math.isfinite(number) else None


NO_GAP = Gap(
    before=0.0,
    after=0.0,
    floor=0.0,
    shrink=0.0,
    shrink_ci=(0.0, 0.0),
    at_floor=True,
    p_value_before=1.0,
    p_value_after=1.0,
    by_family={},
    harmed=None,
    placebo=0.0,
)
"""Of a capture in which none could be measured."""
