"""One twin, waited for: the diagnosis begins many of them ahead."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery, begun_twin
from analysis.gap.look.observation import Observation
from foundation.cores import products_on_one_core
from sensor.effect import Effect


def twin(
    scenery: Scenery,
    base: Base,
    *,
    effects: Sequence[Effect] = (),
    seed: int = 0,
    body: int | None = None,
) -> Observation:
    """One simulated capture, a group of frames of each shot, looked at; see `begun_twin`."""
    with products_on_one_core():
        return begun_twin(scenery, base, effects=effects, seed=seed, body=body)()
