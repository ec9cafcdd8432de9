"""The statistical harness: one significance for every test, shared among its comparisons.

Seeds are fixed, so a test either always passes or never does. The significance says how surprising
the fixed draw may be before we call the code wrong: 1e-4 for a whole test, divided by the number
of comparisons it makes (Bonferroni).
"""

from __future__ import annotations

import numpy as np
from scipy import stats

SIGNIFICANCE = 1e-4


def z_limit(comparisons: int = 1) -> float:
    """How many standard errors a figure may be off in a test with so many comparisons."""
    return float(stats.norm.isf(SIGNIFICANCE / comparisons / 2))


def worst_z(values: object, expected: object, errors: object) -> tuple[float, float]:
    """The largest |value - expected| in standard errors, and the limit for that many values."""
    z = np.abs(
        (np.asarray(values, float) - np.asarray(expected, float)) / np.asarray(errors, float)
    )
    return float(np.max(z)), z_limit(z.size)


def assert_agree(values: object, expected: object, errors: object, what: str = "") -> None:
    """Figures with standard errors agree with what was expected of them."""
    worst, limit = worst_z(values, expected, errors)
    assert worst <= limit, f"{what}: {worst:.2f} standard errors, at most {limit:.2f} expected"


def variance_error(variance: object, samples: int) -> np.ndarray:
    """Standard error of a variance of Gaussian samples: sqrt(2 / (n - 1)) of it."""
    return np.asarray(variance, float) * np.sqrt(2 / (samples - 1))
