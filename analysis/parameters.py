"""Noise parameters: what every estimator returns, and its JSON.

A figure that frames cannot tell is an answer too: a `CannotTell` with the reason.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

FORMAT = "camtruth-noise/1"

UNITS: Mapping[str, str] = {
    "read": "DN",
    "fpn": "DN",
    "dark_shot": "DN",
    "shot_coefficient": "DN^0.5",
    "shot_offset": "DN",
    "prnu_slope": "1",
    "prnu_offset": "DN",
    "gain": "DN/e-",
    "dsnu": "DN",
    "prnu": "1",
}
"""Every parameter that an estimator can report, with its unit."""

PAPER_KEYS = (
    "read",
    "fpn",
    "dark_shot",
    "shot_coefficient",
    "shot_offset",
    "prnu_slope",
    "prnu_offset",
)
"""The parameters of the paper's equations (10) to (16)."""


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A figure with its standard error, both in `unit`."""

    value: float
    se: float
    unit: str

    def to_json(self) -> dict[str, Any]:
        """The figure as the contract spells it."""
        return {"value": self.value, "se": self.se, "unit": self.unit}


@dataclass(frozen=True, kw_only=True)
class CannotTell:
    """No figure, because these frames do not hold it; `reason` says why and what would."""

    reason: str

    def to_json(self) -> dict[str, Any]:
        """The absence as the contract spells it."""
        return {"value": None, "reason": self.reason}


Finding = Estimate | CannotTell


@dataclass(frozen=True, kw_only=True)
class Point:
    """One panel of one shot in one channel: what the noise curves are drawn from.

    Attributes:
        mean_dn: mean pixel value.
        temporal_dn, spatial_dn: measured noise as it stands in the frames.
        rows_dn, columns_dn: total noise by row and by column.
        Further figures of a method, by name in `more`.
    """

    shot: str
    panel: str
    channel: str
    mean_dn: float
    temporal_dn: float
    spatial_dn: float
    rows_dn: float | None = None
    columns_dn: float | None = None
    more: Mapping[str, float] | None = None

    def to_json(self) -> dict[str, Any]:
        """All figures of the point."""
        plain = {k: v for k, v in vars(self).items() if k != "more" and v is not None}
        return plain | dict(self.more or {})


@dataclass(frozen=True, kw_only=True)
class NoiseParameters:
    """What an estimator found in a capture.

    Attributes:
        method: name of the estimator.
        channels: findings by channel (R, G, B, or Y) and parameter (a key of `UNITS`).
        points: the measurements behind them, one per shot, panel and channel.
        warnings: what a careful reader must know before using the figures.
        extra: further figures of the method, plain data.
    """

    method: str
    channels: Mapping[str, Mapping[str, Finding]]
    points: tuple[Point, ...] = ()
    warnings: tuple[str, ...] = ()
    extra: Mapping[str, Any] | None = None

    def to_json(self) -> dict[str, Any]:
        """The document of the contract, with additions."""
        return {
            "format": FORMAT,
            "method": self.method,
            "channels": {
                channel: {key: finding.to_json() for key, finding in findings.items()}
                for channel, findings in self.channels.items()
            },
            "panels": [point.to_json() for point in self.points],
            "warnings": list(self.warnings),
        } | dict(self.extra or {})
