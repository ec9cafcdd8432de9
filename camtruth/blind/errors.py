"""InputError
└── BlindError    a withheld set, its answers or its seal are not what they should be."""

from __future__ import annotations

from foundation.errors import InputError


class BlindError(InputError):
    """A withheld set, its answers or its seal cannot be used as asked."""
