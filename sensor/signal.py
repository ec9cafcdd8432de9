"""The signal on its way through the camera, and the four quantities it can be.

    rate        (f, H, W, 3)  photo-electrons per second under each colour filter, f = 1 or F
    electrons   (f, H, W)     charge of each pixel in e-; a mean until photon shot noise draws it
    DN          (F, H, W) or (F, H, W, 3)  output of the converter, not rounded yet
    code        the same shapes, whole numbers: what leaves the camera

F is the number of frames in the batch. An axis of length 1 stands for "the same in every frame"
and broadcasts, so that nothing is computed per frame before it differs per frame.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from foundation.backend import Backend
from sensor.colours import CHANNELS, Colours
from sensor.limits import greater, lesser
from sensor.neighbours import fetched, run_length
from sensor.planes import Planes
from sensor.protocol import Shot
from sensor.sampled import Sampled

if TYPE_CHECKING:
    from sensor.interpolation import Interpolated


class Quantity(Enum):
    """What the numbers of a signal are, in the order they follow one another."""

    RATE = "e-/s"
    ELECTRONS = "e-"
    DN = "DN"
    CODE = "DN, whole"

    @functools.cached_property
    def place(self) -> int:
        """Position in the order of the signal path."""
        return list(Quantity).index(self)


@dataclass(frozen=True, kw_only=True)
class Format:
    """What an effect may know of the camera it is in.

    Attributes:
        height, width: pixels.
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1); ``"GGGG"`` without a mosaic, ``"RGB"``
            behind three sensors, ``"RRRR"`` of one of them.
        bits: bits of an output pixel.
        gain_dn_per_e: conversion by colour.
        black_dn: black level.
    """

    height: int
    width: int
    cfa: str
    bits: int
    gain_dn_per_e: Colours
    black_dn: float

    @property
    def top_dn(self) -> int:
        """The largest pixel value."""
        return int(2**self.bits - 1)

    @property
    def colour_index(self) -> NDArray[np.uint8]:
        """Which of R, G, B each pixel sees: (H, W), 0 to 2."""
        phase = np.array(["RGB".index(c) for c in self.cfa], dtype=np.uint8).reshape(2, 2)
        rows, columns = -(-self.height // 2), -(-self.width // 2)
        return np.tile(phase, (rows, columns))[: self.height, : self.width]


@dataclass(frozen=True, kw_only=True, eq=False)
class Signal:
    """A batch of frames somewhere between the sensor plane and the cable.

    Attributes:
        numbers: a Dr.Jit tensor in the shapes listed at the top of this file, or the same numbers
            by their place in a run, or made where somebody looks; read `value`, which is always the
            tensor.
        quantity: what its numbers are.
        format: what the camera is.
        shot: how the frames are taken.
        frames: indices of the frames in the shot; negative ones run in before the first.
        rates: light of each lamp at level 1, (H, W, 3) in e-/s: what the scene looks like, also in
            shots in which no lamp is on.
        clamp_e: mean dark charge in e- that the optical-black clamp takes off before conversion.
        backend: where the arithmetic runs.
        least, most: bounds that no number lies below and above, where somebody has looked.
        interpolated: where the numbers are colours that were just made of a mosaic, how.
    """

    numbers: Any
    quantity: Quantity
    format: Format
    shot: Shot
    frames: range
    backend: Backend
    rates: Mapping[str, NDArray[np.float32]] = dataclasses.field(default_factory=dict)
    clamp_e: float = 0.0
    least: float | None = None
    most: float | None = None
    interpolated: Interpolated | None = None

    def replace(self, value: Any, **changes: Any) -> Signal:
        """The same signal with other numbers: a tensor, or planes."""
        return dataclasses.replace(
            self, numbers=value, **{"least": None, "most": None, "interpolated": None, **changes}
        )

    def looked_at(self) -> Signal:
        """The same signal, its least and its largest number known. Waits for the arithmetic, hence
        once a shot.
        """
        value = self.value
        lowest = highest = value.array
        if isinstance(self.numbers, Planes) and not self.numbers.run_in:
            parts = [part for parts in self.numbers.colours for part in parts]
            lowest, highest = functools.reduce(lesser, parts), functools.reduce(greater, parts)
            dr.eval(value, lowest, highest)
        least, most = float(dr.min(lowest)[0]), float(dr.max(highest)[0])
        return dataclasses.replace(self, numbers=value, least=least, most=most)

    @property
    def value(self) -> Any:
        """The numbers as a Dr.Jit tensor."""
        return self.numbers.tensor if isinstance(self.numbers, (Planes, Sampled)) else self.numbers

    @property
    def planes(self) -> Planes:
        """The mosaic, or three colours, by their place in a run."""
        held = self.numbers
        if isinstance(held, Planes) and not held.run_in:
            return held
        return Planes.of(self.value, self.backend.arrays)

    def pointwise(self, change: Callable[..., Any], *beside: Any, **changes: Any) -> Signal:
        """The same signal after a change that looks at each number by itself.

        Args:
            change: of flat arrays or tensors; called with the numbers, and with what is beside.
            beside: what else is looked at in every pixel: a figure, one per colour, a tensor
                (1 or F, H, W) or (F, 1, 1), or numbers by their place in a run.
            changes: other attributes of the new signal.
        """
        held = self.numbers
        if not beside and isinstance(held, Planes):
            return self.replace(held.map(change), **changes)
        if not beside:
            value = self.value
            return self.replace(type(value)(change(value.array), self.shape), **changes)
        fours = self.backend.jit and not self.coloured and self.shape[2] % 4 == 0
        drawn = any(isinstance(n, Planes) for n in (held, *beside))
        if not fours or not (drawn or self.shape[0] > 1):
            plain = [n.tensor if isinstance(n, Planes) else self.by_colour(n) for n in beside]
            changed = change if self.backend.jit else functools.partial(_without_kernels, change)
            return self.replace(changed(self.value, *plain), **changes)
        shapes = [n.shape for n in (held, *beside) if not isinstance(n, (int, float, Colours))]
        frames = max(shape[0] for shape in shapes)
        runs = [self._in_runs(numbers, frames) for numbers in (held, *beside)]
        parts = tuple(change(*numbers) for numbers in zip(*runs, strict=True))
        shape = (frames, *self.shape[1:])
        made = Planes(colours=(parts,), shape=shape, arrays=self.backend.arrays)
        return self.replace(made, **changes)

    def _in_runs(self, numbers: Any, frames: int) -> Sequence[Any]:
        """Numbers for every pixel of a mosaic by their place in runs."""
        _, height, width = self.shape
        length = run_length(self.backend.arrays, width)
        if isinstance(numbers, (int, float)):
            return [self.figure(numbers)] * length
        index = self.backend.arrays.UInt32
        lane = dr.arange(index, frames * height * width // length)
        if isinstance(numbers, Colours):
            if numbers.uniform:
                return [self.figure(numbers.R)] * length
            odd_row = ((lane // (width // length)) % height & 1) == 1
            figure = {c: dr.opaque(self.backend.arrays.Float, numbers[c]) for c in CHANNELS}
            at = [figure[colour] for colour in self.format.cfa]
            return [dr.select(odd_row, at[2 + k], at[k]) for k in (0, 1)] * (length // 2)
        if isinstance(numbers, Planes) and numbers.shape[0] == frames and not numbers.run_in:
            return numbers.colours[0]
        tensor = numbers.tensor if isinstance(numbers, Planes) else numbers
        flat = self.backend.arrays.Float(tensor.array)
        dr.eval(flat)
        frame = height * width // length
        if tensor.shape[1:] == (1, 1):  # one number a frame
            return [dr.gather(type(flat), flat, lane // frame)] * length
        return fetched(flat, lane if tensor.shape[0] == frames else lane % frame, length)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the numbers, the frame axis first."""
        return tuple(self.numbers.shape)

    @property
    def coloured(self) -> bool:
        """Whether every pixel has three values (the last axis)."""
        return len(self.shape) == 4

    def coordinates(self) -> tuple[Any, Any, Any]:
        """Frame, row and column of every pixel of the batch: three flat arrays of f H W indices."""
        frames, height, width = self.shape[:3]
        index = dr.uint32_array_t(dr.array_t(self.backend.arrays.TensorXf))
        lane = dr.arange(index, frames * height * width)
        frame = lane // (height * width)
        pixel = lane - frame * (height * width)
        row = pixel // width
        return frame, row, pixel - row * width

    def colour_of_pixel(self) -> Any:
        """Which of R, G, B (0 to 2) each pixel of the mosaic sees: flat, f H W."""
        _, row, column = self.coordinates()
        codes = ["RGB".index(c) for c in self.format.cfa]
        top = dr.select((column & 1) == 0, type(row)(codes[0]), type(row)(codes[1]))
        bottom = dr.select((column & 1) == 0, type(row)(codes[2]), type(row)(codes[3]))
        return dr.select((row & 1) == 0, top, bottom)

    def mosaic_index(self) -> Any:
        """Where, in a flat (f, H, W, 3), the colour stands that each pixel of the mosaic sees."""
        colour = self.colour_of_pixel()
        return dr.arange(type(colour), dr.width(colour)) * 3 + colour

    def figure(self, value: float) -> Any:
        """A figure of an effect as data of a kernel, so that another value compiles nothing.

        Nought stays a number: what it multiplies is not computed.
        """
        if value == 0 or not self.backend.jit:
            return value
        return dr.opaque(dr.array_t(self.backend.arrays.TensorXf), value)

    def by_colour(self, figure: Any) -> Any:
        """A figure, or one per colour, in a shape that broadcasts against the numbers; see
        `figure`. What is no such thing is returned as it is.
        """
        if isinstance(figure, (int, float)):
            return self.figure(figure)
        if not isinstance(figure, Colours):
            return figure
        if figure.uniform:
            return self.figure(figure.R)
        if self.coloured:
            values = self.backend.tensor([figure.R, figure.G, figure.B])
            return self.backend.arrays.TensorXf(values.array, (1, 1, 1, 3))
        if not self.backend.jit:
            values = np.array([figure[name] for name in CHANNELS])
            return self.backend.tensor(values[self.format.colour_index][None])
        # choosing afresh in every frame costs a fused kernel less than reading one frame's choice
        colour = self.colour_of_pixel()
        number = dr.array_t(self.backend.arrays.TensorXf)
        red, green, blue = (dr.opaque(number, figure[name]) for name in CHANNELS)
        flat = dr.select(colour == 0, red, dr.select(colour == 1, green, blue))
        return self.backend.arrays.TensorXf(flat, self.shape)

    def numpy(self) -> NDArray[np.float32]:
        """The numbers as a NumPy array with its frame axis at full length F."""
        values = np.asarray(self.value.numpy(), dtype=np.float32).reshape(self.shape)
        return np.broadcast_to(values, (len(self.frames), *values.shape[1:]))

    def from_numpy(self, values: NDArray[Any]) -> Signal:
        """The same signal with numbers from NumPy, for the codecs that work there."""
        return self.replace(self.backend.tensor(values))


def _without_kernels(change: Callable[..., Any], first: Any, *beside: Any) -> Any:
    """A change of tensors that broadcast, where nothing is compiled, as flat arrays.

    Dr.Jit looks up the place of every number of a tensor that it stretches; NumPy stretches one
    in a tenth of the time.
    """
    tensors = [n for n in (first, *beside) if not isinstance(n, (int, float))]
    shape = np.broadcast_shapes(*(tuple(n.shape) for n in tensors))

    def flat(numbers: Any) -> Any:
        if isinstance(numbers, (int, float)) or tuple(numbers.shape) == shape:
            return getattr(numbers, "array", numbers)
        return type(first.array)(np.broadcast_to(numbers.numpy(), shape).ravel())

    return type(first)(change(*map(flat, (first, *beside))), shape)
