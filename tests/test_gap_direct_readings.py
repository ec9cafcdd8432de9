"""What is told of a suspect stays inside the ranges of its effect."""

from __future__ import annotations

from analysis.gap.suspects.attribute import as_hinted
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise


def test_what_is_told_beyond_a_range_ends_at_it() -> None:
    """A share of traps of 1.13, as blocks of a codec seem to have, was an error of the input."""
    known = RandomTelegraphNoise(fraction=0.01, amplitude_e=60.0)
    found = as_hinted(known, {"fraction": 1.13, "amplitude_e": 80.0})
    assert isinstance(found, RandomTelegraphNoise)
    most = next(p.maximum for p in known.parameters() if p.name == "fraction")
    assert (found.fraction, found.amplitude_e) == (most, 80.0)
    assert found.dwell_up_s == known.dwell_up_s
