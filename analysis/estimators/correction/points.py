"""The measurements behind the corrected estimator, panel by panel, as points of its curves."""

from __future__ import annotations

import numpy as np

from analysis.estimators.correction.blocks import Block, Seen
from analysis.estimators.correction.patterns import Covariances
from analysis.parameters import Point


def points_of(
    channel: str,
    blocks: tuple[Block, ...],
    black: tuple[float, ...],
    covariances: list[Covariances | None],
) -> list[Point]:
    """One point for each panel and shot whose codes tell something, lattices pooled.

    `temporal_dn` is the noise before rounding; `spatial_dn` the fixed pattern less what averaging
    leaves of the noise in time.
    """
    found = []
    for panel in dict.fromkeys(block.lattice.panel for block in blocks):
        own = [k for k, block in enumerate(blocks) if block.lattice.panel == panel]
        spatial = [_pattern_dn2(blocks[k], covariances[k]) for k in own]
        for label in dict.fromkeys(s.shot.label for k in own for s in blocks[k].used):
            parts = [
                (s, spatial[j][label])
                for j, k in enumerate(own)
                for s in blocks[k].used
                if s.shot.label == label
            ]
            found.append(_point(panel, channel, parts, float(np.mean([black[k] for k in own]))))
    return found


def _pattern_dn2(block: Block, measured: Covariances | None) -> dict[str, float]:
    """Variance of the fixed pattern by label of the shot."""
    if measured is None:
        return {}
    left = np.diag(measured.products) - measured.error
    return {s.shot.label: float(v) for s, v in zip(block.used, left, strict=True)}


def _point(panel: str, channel: str, parts: list[tuple[Seen, float]], black_dn: float) -> Point:
    shot = parts[0][0].shot
    cells = [s.cell for s, _ in parts]
    temporal = float(np.mean([cell.variance_dn2 for cell in cells]))
    temporal_se = float(np.linalg.norm([cell.variance_se_dn2 for cell in cells])) / len(cells)
    spatial = float(np.mean([variance for _, variance in parts]))
    more = {
        "exposure_s": shot.exposure_s,
        "at_zero": float(np.mean([cell.at_zero for cell in cells])),
        "at_top": float(np.mean([cell.at_top for cell in cells])),
        "temporal_variance_dn2": temporal,
        "temporal_variance_se_dn2": temporal_se,
        "spatial_variance_dn2": spatial,
        "black_dn": black_dn,
    }
    return Point(
        shot=shot.label,
        panel=panel,
        channel=channel,
        mean_dn=float(np.mean([cell.mean_dn for cell in cells])),
        temporal_dn=temporal**0.5,
        spatial_dn=max(spatial, 0.0) ** 0.5,
        more=more,
    )
