"""Errors of the sensor.

SensorError
├── CameraError     a camera, effect or parameter that no camera can have
├── ProtocolError   a shot that cannot be taken
└── CaptureError    frames or a capture folder that do not hold what they say
    └── TooFewFrames   one frame where two are needed
"""

from foundation.errors import InputError


class SensorError(InputError):
    """Anything wrong on the way from photo-electrons to pixels."""


class CameraError(SensorError):
    """A camera, effect or parameter that no camera can have."""


class ProtocolError(SensorError):
    """A shot that cannot be taken."""


class CaptureError(SensorError):
    """Frames or a capture folder that do not hold what they say."""


class TooFewFrames(CaptureError):  # noqa: N818  reads as what it is
    """One frame where two are needed."""
