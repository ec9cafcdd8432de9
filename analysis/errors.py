"""Errors of the analysis.

AnalysisError
└── MethodError   an estimator that does not exist, cannot be loaded, or breaks its contract
"""

from foundation.errors import InputError


class AnalysisError(InputError):
    """Anything wrong on the way from pixels to knowledge."""


class MethodError(AnalysisError):
    """An estimator that does not exist, cannot be loaded, or breaks its contract."""
