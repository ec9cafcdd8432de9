"""Which lamps have a hot wire, by their names."""

from __future__ import annotations

from sensor.protocol import Shot

FILAMENTS = frozenset({"incandescent", "tungsten", "halogen"})
"""Names of lamps whose light comes from a hot wire."""


def has_filament(shot: Shot) -> bool:
    """Whether all light of a shot comes from hot wires."""
    return FILAMENTS.issuperset(shot.light)
