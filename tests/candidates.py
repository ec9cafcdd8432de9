"""A suspect with a score and nothing else."""

from __future__ import annotations

import numpy as np

from analysis.gap.camera.base import Base
from analysis.gap.measure.case import Candidate
from sensor.catalogue import catalogue

BASE = Base(
    channels=("Y",),
    gain_dn_per_e=np.ones(1),
    read_dn2=np.ones(1),
    fpn_dn2=np.ones(1),
    prnu2=np.ones(1),
    black_dn=np.zeros(1),
    dark_e_per_s=0.0,
    shown_e_per_s=0.0,
    dark_spread2=0.0,
    dark_uneven=0.0,
    clamp_e2=0.0,
    arithmetic=0,
    white_balance=None,
    blur_px2=0.0,
    level={},
)


def candidate(name: str, score: float) -> Candidate:
    """A suspect with a score and nothing else."""
    return Candidate(
        effect=catalogue()[name](),
        base=BASE,
        score=score,
        forward=score,
        absorbed=0.0,
        misfit=1.0,
        scenery=None,  # type: ignore[arg-type]
    )
