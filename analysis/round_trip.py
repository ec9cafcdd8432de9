"""Truth that went in against the estimate that came out, over many camera bodies.

Running the simulations is done elsewhere; here their results become bias with its standard error,
RMS error and coverage, a row for each parameter, channel and method.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from analysis.parameters import UNITS, Estimate, NoiseParameters

FORMAT = "camtruth-roundtrip/1"

CONFIDENCE = 0.95
"""Nominal coverage of the interval estimate +- 1.96 standard errors."""

Truth = Mapping[str, Mapping[str, float]]
"""Population values by channel and parameter."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """How one method does on one parameter of one channel; figures in `unit`.

    Attributes:
        truth: mean of the population values.
        estimate: mean of the estimates that were given; None where there was none.
        bias: mean of estimate less truth.
        bias_se: standard error of `bias`, from the scatter over seeds; with one seed, the
            estimate's own.
        rms: root mean square of estimate less truth.
        coverage: share of intervals that hold the truth.
        seeds: how often it was tried.
        answered: share of the tries that gave a figure rather than "cannot tell".
        reason: the commonest reason why not, where any were unanswered.
    """

    parameter: str
    channel: str
    method: str
    unit: str
    truth: float
    estimate: float | None
    bias: float | None
    bias_se: float | None
    rms: float | None
    coverage: float | None
    seeds: int
    answered: float
    reason: str | None = None

    def to_json(self) -> dict[str, Any]:
        """The row of the contract, with additions."""
        return dict(vars(self))


def round_trip(trips: Iterable[tuple[Truth, NoiseParameters]]) -> tuple[Row, ...]:
    """Compare estimates with truth; `trips` holds one pair for each seed and method, in any order.

    A parameter without a truth, or that the method does not report, has no row. Rows come in the
    order in which methods, channels and parameters first appear.
    """
    gathered: dict[tuple[str, str, str], list[tuple[float, Estimate | str]]] = {}
    for truth, found in trips:
        for channel, findings in found.channels.items():
            for key, finding in findings.items():
                if key not in truth.get(channel, {}):
                    continue
                outcome = finding if isinstance(finding, Estimate) else finding.reason
                gathered.setdefault((found.method, channel, key), []).append(
                    (float(truth[channel][key]), outcome)
                )
    return tuple(_row(*name, tries) for name, tries in gathered.items())


def document(rows: Iterable[Row], seeds: int) -> dict[str, Any]:
    """The round trip as `roundtrip --json` answers it."""
    return {"format": FORMAT, "seeds": seeds, "rows": [row.to_json() for row in rows]}


def _row(method: str, channel: str, key: str, tries: list[tuple[float, Estimate | str]]) -> Row:
    pairs = [(truth, got) for truth, got in tries if isinstance(got, Estimate)]
    reasons = [got for _, got in tries if isinstance(got, str)]
    error = np.array([got.value - truth for truth, got in pairs])
    se = np.array([got.se for _, got in pairs])
    estimate = bias = bias_se = rms = coverage = None
    if pairs:
        estimate = float(np.mean([got.value for _, got in pairs]))
        bias = float(error.mean())
        bias_se = (
            float(error.std(ddof=1) / math.sqrt(error.size)) if error.size > 1 else float(se[0])
        )
        rms = float(np.sqrt(np.mean(error**2)))
        reach = float(stats.norm.ppf((1 + CONFIDENCE) / 2))
        coverage = float(np.mean(np.abs(error) <= reach * se))
    return Row(
        parameter=key,
        channel=channel,
        method=method,
        unit=pairs[0][1].unit if pairs else UNITS.get(key, ""),
        truth=float(np.mean([truth for truth, _ in tries])),
        estimate=estimate,
        bias=bias,
        bias_se=bias_se,
        rms=rms,
        coverage=coverage,
        seeds=len(tries),
        answered=len(pairs) / len(tries),
        reason=max(set(reasons), key=lambda reason: (reasons.count(reason), reason))
        if reasons
        else None,
    )
