"""Random telegraph noise."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter, switch
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.thermal import darkness_s


@dataclass(frozen=True, kw_only=True)
class RandomTelegraphNoise(Effect):
    """In a few photosites a single trap fills and empties, and shifts the level up and down.

    A Markov chain of two levels, 0 and A, with mean dwell times t_up and t_down, looked at once a
    frame. The chain forgets itself at the events of a Poisson process of rate 1/tau = 1/t_up +
    1/t_down; at each it is up with probability p = t_up / (t_up + t_down), and in between it stays:
    exactly that chain, and one that any frame can look up without running through those before it.

    Over the affected photosites A = a E^s / Gamma(1 + s) with E exponential of mean 1: of mean a
    for each s, exponential for s = 1, the same in all for s = 0. Or ln(A / a) is normal, of mean
    -s^2 / 2 and standard deviation s. A trap that makes dark current makes more in longer
    exposures and in the heat, a Poisson count of the mean A (t / 0.1 s) 2^((T - 29 degC) / 8 degC).

    Consequence: an affected photosite shows two levels and no more, with variance A^2 p (1 - p)
    and correlation exp(-k interval / tau) between frames k apart. Independent noise of equal
    variance shows neither. The mean of A^2 is a^2 Gamma(1 + 2 s) / Gamma(1 + s)^2, or a^2 exp(s^2).
    """

    name: ClassVar[str] = "random_telegraph_noise"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 55
    product: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "Hopkins and Hopkinson, Random telegraph signals from proton-irradiated CCDs, IEEE Trans. "
        "Nucl. Sci. 40, 1993; Wang et al., Random telegraph signal in CMOS image sensor pixels, "
        "IEDM 2006"
    )

    fraction: float = parameter(
        0.01,
        unit="1",
        minimum=0.0,
        maximum=0.3,
        identity=0.0,
        doc="share of the photosites that have such a trap",
    )
    amplitude_e: float = parameter(
        200.0,
        unit="e-",
        minimum=0.0,
        maximum=10_000.0,
        identity=0.0,
        starts=(200.0, 60.0, 20.0),
        doc="mean difference between the two levels",
    )
    dwell_up_s: float = parameter(
        0.5, unit="s", minimum=1e-3, maximum=1000.0, doc="mean time at the upper level"
    )
    dwell_down_s: float = parameter(
        1.0, unit="s", minimum=1e-3, maximum=1000.0, doc="mean time at the lower level"
    )
    spread: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=2.0,
        stated=True,
        doc="how unlike the differences are: 0 the same in every such photosite, 1 exponential",
    )
    lognormal: float = switch(
        0.0, starts=(0.0,), doc="1 differences are lognormal, and spread is that of their logarithm"
    )
    of_dark_current: float = switch(
        0.0,
        starts=(0.0,),
        doc="1 traps make dark current: amplitude_e is that of 0.1 s at 29 degC",
    )

    @property
    def tau_s(self) -> float:
        """Correlation time of the chain."""
        return 1.0 / (1.0 / self.dwell_up_s + 1.0 / self.dwell_down_s)

    def sizes(self, exponential: Any, normal: Any) -> Any:
        """Differences in units of their mean, from random numbers of which it needs one kind.

        Args:
            exponential: of mean 1, any array.
            normal: standard normal, alike.
        """
        if self.lognormal:
            # in this way for arrays of NumPy and of Dr.Jit
            return math.e ** (self.spread * normal - 0.5 * self.spread**2)
        return exponential**self.spread / math.gamma(1.0 + self.spread)

    def mean_e(self, darkness_s: float) -> float:
        """Mean difference between the two levels, in electrons.

        Args:
            darkness_s: exposure in which as much dark current gathers at 29 degC.
        """
        return self.amplitude_e * (darkness_s / TOLD_S if self.of_dark_current else 1.0)

    @property
    def share_up(self) -> float:
        """Probability of the upper level."""
        return self.dwell_up_s / (self.dwell_up_s + self.dwell_down_s)

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        frames, pixels = len(signal.frames), signal.shape[1] * signal.shape[2]
        value = signal.value + dr.zeros(type(signal.value), (frames, 1, 1))
        places = dr.compress(stream.body.uniform(pixels, use="where").array < self.fraction)
        traps = dr.width(places)
        if traps == 0:
            return signal.replace(value)
        # lanes come in powers of two, so that another body does not compile another kernel
        lanes = 1 << (traps - 1).bit_length()
        state = self.levels(signal, stream, lanes)

        flat = type(value.array)
        index = dr.uint32_array_t(flat)
        lane = dr.arange(index, frames * lanes)
        frame = lane // lanes
        trap = lane - frame * lanes
        drawn = -dr.log(1.0 - stream.body.uniform(lanes, use="size").array)
        normal = stream.body.normal(lanes, use="size").array
        size = self.mean_e(darkness_s(signal.shot)) * self.sizes(drawn, normal)
        dr.eval(places, size)
        real = trap < dr.opaque(index, traps)
        shift = dr.select(state, dr.gather(flat, size, trap), 0.0)
        if self.of_dark_current:
            charge = stream.poisson(type(value)(shift, (frames, lanes)), use="shot")
            shift = charge.array
        shifted = +value.array
        dr.scatter_add(
            shifted,
            shift,
            frame * pixels + dr.gather(index, places, trap, real),
            real,
        )
        return signal.replace(type(value)(shifted, value.shape))

    def levels(self, signal: Signal, stream: Stream, lanes: int) -> Any:
        """Whether each trap is at its upper level: flat mask, frame by frame.

        Time is cut into cells of about tau, and the events of a cell are drawn by their age at its
        end, youngest first. A frame needs the youngest event before it: in its own cell, or else in
        the cells before, of which all are empty with probability `FORGOTTEN` at most.
        """
        shot = signal.shot
        interval_s = max(shot.interval_s or shot.exposure_s, SHORTEST_S)
        cell_frames = max(1, int(self.tau_s / interval_s))
        cell_taus = cell_frames * interval_s / self.tau_s
        earlier = math.ceil(-math.log(FORGOTTEN) / cell_taus)
        first = signal.frames.start // cell_frames - earlier
        cells = range(first, (signal.frames.stop - 1) // cell_frames + 1)
        events = dataclasses.replace(stream, frames=cells)
        ages, ups, age = [], [], 0.0
        for k in range(EVENTS):
            age = age - dr.log(1.0 - events.uniform(lanes, use=f"age {k}").array) / cell_taus
            ages.append(age)
            ups.append(events.uniform(lanes, use=f"level {k}").array < self.share_up)
        dr.eval(ages, ups)

        flat, mask = type(ages[0]), type(ups[0])
        index = dr.uint32_array_t(flat)
        start = dr.opaque(index, signal.frames.start - first * cell_frames)
        lane = dr.arange(index, len(signal.frames) * lanes)
        frame = start + lane // lanes
        cell = frame // cell_frames
        at = cell * lanes + lane % lanes
        to_go = 1.0 - flat(frame - cell * cell_frames) / cell_frames  # from the frame to cell's end
        up = dr.gather(mask, ups[0], at - earlier * lanes)
        for back in range(earlier - 1, 0, -1):
            happened = dr.gather(flat, ages[0], at - back * lanes) < 1.0
            up = dr.select(happened, dr.gather(mask, ups[0], at - back * lanes), up)
        for k in range(EVENTS - 1, -1, -1):
            age = dr.gather(flat, ages[k], at)
            up = dr.select((age >= to_go) & (age < 1.0), dr.gather(mask, ups[k], at), up)
        return up


TOLD_S = 0.1
"""Exposure for which the amplitude of traps that make dark current is told."""

FORGOTTEN = 1e-4
"""How seldom the look back ends before an event was found."""

EVENTS = 7
"""Events drawn in a cell; more than 7 happen with probability 1e-5 where a cell lasts one tau."""

SHORTEST_S = 1e-3
"""Time from frame to frame where a shot tells none and has no exposure either."""
