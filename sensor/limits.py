"""The lesser and the greater of two numbers, and numbers held between limits, cheaply.

One instruction each; Dr.Jit's own take five, because they pass on what is not a number.
"""

from __future__ import annotations

from typing import Any

import drjit as dr


def lesser(a: Any, b: Any) -> Any:
    """The smaller of two."""
    return dr.select(a < b, a, b)


def greater(a: Any, b: Any) -> Any:
    """The larger of two."""
    return dr.select(a > b, a, b)


def at_least(value: Any, low: float) -> Any:
    """The value, or the limit where it is below."""
    return greater(value, low)


def between(value: Any, low: float, high: float) -> Any:
    """The value, or the nearer limit where it is outside."""
    return lesser(greater(value, low), high)
