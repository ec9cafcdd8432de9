"""Errors of the exchange with other programs.

ExchangeError            a capture that a format cannot hold, or files that are no capture
└── MissingLibraryError  an optional library that the format needs is not installed
"""

from foundation.errors import InputError


class ExchangeError(InputError):
    """A capture that a format cannot hold, or files that are no capture."""


class MissingLibraryError(ExchangeError):
    """An optional library that the format needs is not installed."""
