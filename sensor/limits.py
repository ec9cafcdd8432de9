"""Numbers held between limits, cheaply."""

from __future__ import annotations

from typing import Any

import drjit as dr


def at_least(value: Any, low: float) -> Any:
    """The value, or the limit where it is below.

    One instruction; Dr.Jit's own maximum takes five, because it passes on what is not a number.
    """
    return dr.select(value > low, value, low)


def between(value: Any, low: float, high: float) -> Any:
    """The value, or the nearer limit where it is outside."""
    raised = at_least(value, low)
    return dr.select(raised < high, raised, high)
