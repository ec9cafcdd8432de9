"""Errors of scenes.

InputError
└── SceneError         a scene that cannot be, or that nobody knows
    └── SpectrumError  a spectrum that is incomplete, negative, too coarse or unknown
"""

from __future__ import annotations

from foundation.errors import InputError


class SceneError(InputError):
    """A scene is unknown, or describes something that cannot be photographed."""


class SpectrumError(SceneError):
    """A spectrum cannot be used for a radiometric computation."""
