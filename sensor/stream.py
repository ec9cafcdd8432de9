"""Random numbers as an argument: counter-based, one stream per (seed, effect, shot, frame).

Frame k gets the same numbers alone, in a batch, on one machine or on many, and adding an effect
leaves every other effect's numbers alone. With a JIT backend the numbers come from Philox 4x32
inside the fused kernel; on the scalar backend from NumPy's Philox, which is some twenty times
faster there than a scalar loop of Dr.Jit. The two are equal in distribution.

Reference: Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np

from foundation.backend import Backend
from sensor.box_muller import normals
from sensor.neighbours import run_length
from sensor.philox import Words, fractions, words
from sensor.planes import Planes
from sensor.poisson import SMALL_MEAN, poisson_count, steps_of, steps_reached

if TYPE_CHECKING:
    from sensor.signal import Signal


def key_of(*parts: object) -> int:
    """A 64-bit key from names and numbers; different parts give unrelated keys."""
    text = "\x1f".join(str(part) for part in parts)
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


@dataclass(frozen=True, kw_only=True)
class Stream:
    """The random numbers of one effect in one shot.

    `normal`, `uniform` and `poisson` draw afresh for every frame and return tensors whose first
    axis is the frame. `body` and `whole_shot` are streams of the same kind whose numbers are those
    of the camera body (the same in every shot) or of the shot (the same in every frame); their
    tensors have a first axis of length 1.

    Two draws for different purposes take different words for `use`; the same word gives the same
    numbers again.
    """

    backend: Backend
    seed: int
    body_seed: int
    effect: str
    shot: str
    frames: range
    scope: str = "frame"

    @property
    def body(self) -> Stream:
        """Numbers that belong to the camera body: fixed patterns."""
        return self._with_scope("body")

    @property
    def whole_shot(self) -> Stream:
        """Numbers that are the same in every frame of the shot: a phase, a drift's direction."""
        return self._with_scope("shot")

    def _with_scope(self, scope: str) -> Stream:
        return Stream(
            backend=self.backend,
            seed=self.seed,
            body_seed=self.body_seed,
            effect=self.effect,
            shot=self.shot,
            frames=range(1),
            scope=scope,
        )

    def key(self, use: str = "") -> int:
        """The 64-bit key of this stream for one use."""
        if self.scope == "body":
            return key_of("body", self.body_seed, self.effect, use)
        return key_of(self.scope, self.seed, self.effect, self.shot, use)

    def normal(self, *shape: int, use: str = "") -> Any:
        """Standard normal numbers: a tensor (F, *shape)."""
        if not self.backend.jit:
            return self._numpy(lambda g: g.standard_normal(shape, dtype=np.float32), use)
        return self._tensor(normals(self._words(shape, use)[0]), shape)

    def uniform(self, *shape: int, use: str = "") -> Any:
        """Numbers uniform in [0, 1): a tensor (F, *shape)."""
        if not self.backend.jit:
            return self._numpy(lambda g: g.random(shape, dtype=np.float32), use)
        return self._tensor(fractions(self._words(shape, use)[0]), shape)

    def poisson(self, mean: Any, use: str = "") -> Any:
        """Poisson counts with the given means: a tensor (1 or F, *shape) to one (F, *shape).

        Exact by inversion for means below `SMALL_MEAN`, by an asymptotic quantile above, whose
        error in probability is at most 3.1e-5 and falls with the mean (see sensor/poisson.py).
        """
        shape = tuple(mean.shape)[1:]
        if not self.backend.jit:
            means = np.asarray(mean.numpy()).reshape(tuple(mean.shape))
            rows = iter(np.broadcast_to(means, (len(self.frames), *shape)))
            return self._numpy(lambda g: g.poisson(next(rows)).astype(np.float32), use)
        # one look at a mean that all frames share spares every frame the sum for small means
        least = float(dr.min(mean.array)[0]) if mean.shape[0] == 1 else 0.0
        normal = self.normal(*shape, use=use)
        means = (mean + dr.zeros(type(mean), (len(self.frames), *(1,) * len(shape)))).array
        return type(mean)(poisson_count(means, normal.array, least), normal.shape)

    def noise(self, signal: Signal, use: str = "") -> Any:
        """Standard normal numbers for every pixel of a mosaic, for `Signal.pointwise`.

        The numbers of `normal`, held as they are drawn: nothing is written to memory for them.
        """
        shape = signal.shape[1:]
        if not self.backend.jit or signal.coloured or shape[-1] % 4:
            return self.normal(*shape, use=use)
        length = run_length(self.backend.arrays, shape[-1])
        drawn = tuple(n for words in self._words(shape, use, length // 4) for n in normals(words))
        shape = (len(self.frames), *shape)
        return Planes(colours=(drawn,), shape=shape, arrays=self.backend.arrays)

    def counts(self, signal: Signal, use: str = "") -> Signal:
        """The signal with Poisson counts in place of its means: those of `poisson`."""
        noise = self.noise(signal, use) if self.backend.jit else None
        if not isinstance(noise, Planes):
            return signal.replace(self.poisson(signal.value, use))
        if signal.least is None:
            signal = signal.looked_at()  # it spares every pixel the sum for small means
        least = signal.least or 0.0
        if signal.most == least < SMALL_MEAN:  # one mean for all, as in the dark
            steps = [signal.figure(step) for step in steps_of(least)]
            return signal.replace(noise.map(lambda w: steps_reached(steps, w)))
        return signal.pointwise(lambda mean, w: poisson_count(mean, w, least), noise)

    def _words(self, shape: tuple[int, ...], use: str, blocks: int = 1) -> list[Words]:
        """Random words; every lane makes so many times those of four neighbouring numbers."""
        arrays = self.backend.arrays
        lanes = -(-math.prod(shape) // (4 * blocks))
        lane = dr.arange(arrays.UInt32, lanes * len(self.frames))
        frame = lane // lanes
        start = dr.opaque(arrays.UInt32, self.frames.start % 2**32)
        key = dr.opaque(arrays.UInt64, self.key(use))
        first = (lane - frame * lanes) * blocks
        return [words(key, first + k, start + frame) for k in range(blocks)]

    def _tensor(self, fours: list[Any], shape: tuple[int, ...]) -> Any:
        size = math.prod(shape)
        flat = dr.ravel(self.backend.arrays.Array4f(*fours))
        whole = self.backend.arrays.TensorXf(flat, (len(self.frames), -(-size // 4) * 4))
        flat = whole.array if size % 4 == 0 else whole[:, :size].array
        return self.backend.arrays.TensorXf(flat, (len(self.frames), *shape))

    def _numpy(self, draw: Any, use: str) -> Any:
        rows = [draw(self._generator(frame, use)) for frame in self.frames]
        return self.backend.tensor(np.stack(rows))

    def _generator(self, frame: int, use: str) -> np.random.Generator:
        counter = np.array([0, 0, 0, frame % 2**32], dtype=np.uint64)
        return np.random.Generator(np.random.Philox(key=self.key(use), counter=counter))
