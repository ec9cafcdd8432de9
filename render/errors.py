"""Errors of rendering.

InputError
└── RenderError    a rate image that cannot be read, or a rendering that cannot be done
"""

from __future__ import annotations

from foundation.errors import InputError


class RenderError(InputError):
    """A rate image is unreadable or wrong, or a rendering was asked for that cannot be done."""
