"""Flicker noise."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sensor.effect import Effect, Stage, parameter, switch
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class FlickerNoise(Effect):
    """The output transistor's traps hold and release charge at all rates: noise of spectrum 1/f.

        e(t) += s sum_k sqrt(w_k / P) (a_k cos(2 pi k t / L) + b_k sin(2 pi k t / L)),
        w_k = atan(2 pi k T / L) / k^q,  k = 1 to L/2,    P = sum of all w_k

    over a frame of L pixels in the order of the read-out, t = y W + x, with a_k and b_k standard
    normal and T the time constant of the slowest trap: variance s^2, two-sided spectrum
    S(k / L) = s^2 L w_k / (2 P). One trap gives T_i / (1 + (2 pi f T_i)^2), and as many in every
    octave of T_i up to T give q = 1: equal power in every octave above 1 / (2 pi T),
    so that the variance of means over m pixels falls as the logarithm of m, where that of
    independent noise falls as 1/m; and white noise below. Where slow traps are more than fast ones
    the power falls faster, with q somewhat above 1, and where they are fewer slower.

    Frames are independent, as the clamp is set again before each. It takes the mean of a frame off,
    all of it where many dark pixels tell it and nothing where none do; then L is the pixels of two
    frames, of which one is seen.
    """

    name: ClassVar[str] = "flicker_noise"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 25
    reference: ClassVar[str] = (
        "Dutta and Horn, Low-frequency fluctuations in solids: 1/f noise, Rev. Mod. Phys. 53, 497 "
        "(1981), for the sum of traps; Timmer and König, On generating power law noise, Astron. "
        "Astrophys. 300, 707 (1995), for the sum of waves"
    )

    sigma_e: float = parameter(
        15.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        doc="standard deviation of all waves together",
    )
    slowest_rows: float = parameter(
        1000.0,
        unit="rows",
        minimum=0.1,
        maximum=10000.0,
        starts=(1000.0, 10.0),
        doc="time constant of the slowest trap",
    )
    exponent: float = parameter(
        1.0,
        unit="1",
        minimum=0.5,
        maximum=2.0,
        doc="of the frequency, by which power falls: 1 of as many traps in every octave",
    )
    clamped: float = switch(
        1.0,
        starts=(1.0, 0.0),
        doc="1 the mean of every frame is taken off, 0 it stays",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        import cv2

        frames, height, width = len(signal.frames), *signal.shape[1:3]
        pixels = height * width
        length = pixels if self.clamped else 2 * pixels
        waves = np.asarray(stream.normal(length).numpy()).reshape(frames, length)
        # in place: nobody else holds these numbers
        waves *= _amplitudes(length, self.slowest_rows * width, self.exponent)
        cv2.dft(waves, waves, cv2.DFT_ROWS | cv2.DFT_INVERSE | cv2.DFT_REAL_OUTPUT)
        seen = waves[:, :pixels].reshape(frames, height, width)
        return signal.pointwise(
            lambda e, sigma, noise: e + sigma * noise,
            self.sigma_e,
            signal.backend.tensor(seen),
        )


@functools.lru_cache(maxsize=4)
def _amplitudes(length: int, slowest_px: float, exponent: float) -> NDArray[np.float32]:
    """What the standard normal numbers of a frame are multiplied by.

    They are the spectrum as OpenCV packs that of real numbers: 0, a_1, b_1, a_2, b_2 and so on; an
    even length ends with a_k of the fastest wave, which is a cosine alone. Each a_k and b_k stands
    for k and -k, hence one half; the last stands for itself.
    """
    k = np.arange(1, length // 2 + 1)
    power = np.arctan(2 * np.pi * k * slowest_px / length) / k**exponent
    each = np.sqrt(power / np.sum(power)) / np.where(2 * k == length, 1.0, 2.0)
    packed = np.concatenate([[0.0], np.repeat(each, 2)])
    return packed[:length].astype(np.float32)
