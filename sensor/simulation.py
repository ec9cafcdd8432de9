"""From light to pixels: a camera's effects applied to a batch of frames, in physical order."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from foundation.backend import Backend, backend
from sensor.camera import PRISM, Camera
from sensor.conversion import digitise, expose
from sensor.effect import Effect
from sensor.errors import CameraError
from sensor.frames import PIXELS
from sensor.planes import Planes
from sensor.prism import joined, parts, sensors
from sensor.protocol import Shot
from sensor.signal import Quantity, Signal
from sensor.stream import Stream, key_of
from sensor.whole_numbers import whole_number


def light_on(camera: Camera, shot: Shot, rates: Mapping[str, NDArray[np.float32]]) -> NDArray[Any]:
    """Photo-electrons per second of the shot: the sum of its lamps at their levels, (H, W, 3).

    Raises:
        CameraError: when a lamp has no rate image, or one of another size.
    """
    if shot.dark:
        return np.zeros((camera.height, camera.width, 3), dtype=np.float32)
    total, *more = (
        np.float32(level) * _rate_of(lamp, camera, shot, rates)
        for lamp, level in zip(shot.light, shot.level, strict=True)
    )
    for light in more:
        total += light
    if any(sensitivity != 1.0 for sensitivity in camera.sensitivity):
        total *= np.array(list(camera.sensitivity), dtype=np.float32)
    return np.asarray(total)


def _rate_of(
    lamp: str, camera: Camera, shot: Shot, rates: Mapping[str, NDArray[np.float32]]
) -> NDArray[np.float32]:
    if lamp not in rates:
        raise CameraError(
            f"shot '{shot.label}' is lit by '{lamp}', which has no rate image",
            f"expected one of {', '.join(sorted(rates)) or 'none at all'}",
            f"render it, or pass --rate {lamp}=FILE",
        )
    if rates[lamp].shape != (camera.height, camera.width, 3):
        h, w = rates[lamp].shape[:2]
        raise CameraError(
            f"the rate image of '{lamp}' has {w} x {h} pixels",
            f"expected {camera.width} x {camera.height} as camera '{camera.name}' has",
            "render it at that size",
        )
    return rates[lamp]


def simulate(
    camera: Camera,
    shot: Shot,
    rates: Mapping[str, NDArray[np.float32]],
    *,
    seed: int = 0,
    frames: range | None = None,
    where: Backend | None = None,
    until: Quantity = Quantity.CODE,
) -> Signal:
    """A batch of frames of one shot, as a signal on the backend.

    Args:
        camera: the camera.
        shot: the shot.
        rates: photo-electrons per second by lamp at level 1, each (H, W, 3).
        seed: seed of everything that is not fixed in the camera body.
        frames: which frames of the shot; all by default.
        where: the backend; the fastest by default.
        until: stop before the first effect past this quantity.
    """
    where = where or backend()
    light = lit(camera, shot, rates, where)
    wanted = range(shot.frames) if frames is None else frames
    return exposed(camera, light, wanted, seed=seed, until=until)


def lit(
    camera: Camera, shot: Shot, rates: Mapping[str, NDArray[np.float32]], where: Backend
) -> Signal:
    """The light of a shot, before the first effect."""
    return Signal(
        numbers=where.tensor(light_on(camera, shot, rates)[None]),
        quantity=Quantity.RATE,
        format=camera.format,
        shot=shot,
        frames=range(shot.frames),
        backend=where,
        rates=rates,
    )


def still(camera: Camera, light: Signal, *, seed: int) -> tuple[Signal, int]:
    """What all frames of a shot share, made once, and by how many effects; for a JIT backend.

    Args:
        camera: the camera.
        light: of `lit`.
        seed: seed of everything that is not fixed in the camera body.
    """
    if camera.cfa == PRISM:
        return light, 0
    signal = dataclasses.replace(light, frames=range(2))
    for done, effect in enumerate(camera.chain):
        reached = _reach(signal, effect.quantity())
        stream = stream_of(camera, effect, signal.shot, seed, signal.frames, signal.backend)
        after = effect.apply(reached, stream)
        if after.shape[0] > 1:
            return reached.looked_at(), done
        signal = after
    return signal, len(camera.chain)


def exposed(
    camera: Camera,
    light: Signal,
    frames: range,
    *,
    seed: int,
    done: int = 0,
    until: Quantity = Quantity.CODE,
) -> Signal:
    """What `simulate` does, with the light of the shot already there.

    Args:
        camera: the camera.
        light: of `lit`, or of `still`.
        frames: which frames of the shot.
        seed: seed of everything that is not fixed in the camera body.
        done: how many effects have been applied to the light.
        until: stop before the first effect past this quantity.
    """
    batch = range(frames.start - camera.history_frames, frames.stop)
    signal = dataclasses.replace(light, frames=batch)
    if camera.cfa == PRISM:
        signal = _through_a_prism(camera, signal, seed, until)
    else:
        signal = _through(camera, camera.chain[done:], signal, seed, until)
    signal = _reach(signal, until)
    if signal.shape[0] == len(batch) and len(batch) > len(frames):
        return signal.replace(signal.planes.without(camera.history_frames), frames=frames)
    return dataclasses.replace(signal, frames=frames)


def _through(
    camera: Camera, effects: Sequence[Effect], signal: Signal, seed: int, until: Quantity
) -> Signal:
    """The signal behind some effects of a camera, as far as the quantity that is asked for."""
    for effect in effects:
        if effect.quantity().place > until.place:
            break
        signal = _reach(signal, effect.quantity())
        stream = stream_of(camera, effect, signal.shot, seed, signal.frames, signal.backend)
        signal = effect.apply(signal, stream)
    return signal


def _through_a_prism(camera: Camera, light: Signal, seed: int, until: Quantity) -> Signal:
    """The signal of a camera of three sensors: what each of them has is drawn for itself."""
    before, _, after = parts(camera.chain)
    light = _through(camera, before, light, seed, until)
    if until is Quantity.RATE:
        return light
    converted = min(until, Quantity.DN, key=lambda quantity: quantity.place)
    seen = []
    for colour, one in sensors(camera).items():
        alone = dataclasses.replace(light, format=one.format)
        charge = _through(one, one.effects, alone, key_of(seed, colour), until)
        seen.append(_reach(charge, converted))
    return _through(camera, after, joined(seen, camera), seed, until)


def stream_of(
    camera: Camera, effect: Effect, shot: Shot, seed: int, frames: range, where: Backend
) -> Stream:
    """The random numbers of one effect of a camera in one shot."""
    return Stream(
        backend=where,
        seed=seed,
        body_seed=camera.body_seed,
        effect=effect.name,
        shot=shot.label,
        frames=frames,
    )


def _reach(signal: Signal, quantity: Quantity) -> Signal:
    """Convert the signal step by step until it is the wanted quantity."""
    if signal.quantity is Quantity.RATE and quantity.place > Quantity.RATE.place:
        signal = expose(signal)
    if signal.quantity is Quantity.ELECTRONS and quantity.place > Quantity.ELECTRONS.place:
        signal = digitise(signal)
    if signal.quantity is Quantity.DN and quantity is Quantity.CODE:
        signal = dataclasses.replace(signal, quantity=Quantity.CODE)
    return signal


def pixels_of(camera: Camera, signal: Signal) -> NDArray[Any]:
    """The frames as they leave the camera: (N, H, W, 3) or (N, H, W) of its pixel type.

    A camera without a demosaicer that is to give rgb8, or with one that is not, is a mistake.
    """
    dimensions, kind = PIXELS[camera.pixels]
    if len(signal.shape) != dimensions:
        raise CameraError(
            f"camera '{camera.name}' gives {camera.pixels} "
            f"{'without' if dimensions == 4 else 'with'} a demosaicer",
            "expected a demosaicer for rgb8 and none otherwise",
            "add or remove the effect 'demosaic', or change 'pixels'",
        )
    if kind is np.uint8 and signal.backend.jit and isinstance(signal.numbers, Planes):
        stack = signal.numbers.as_bytes()
    elif kind is np.uint8 and signal.backend.jit:
        codes = signal.backend.arrays.UInt8(whole_number(signal.value.array)).numpy()
        stack = np.asarray(codes).reshape(signal.shape)
    else:
        stack = np.asarray(signal.value.numpy()).reshape(signal.shape).astype(kind)
    return np.broadcast_to(stack, (len(signal.frames), *stack.shape[1:]))


def begin(signal: Signal) -> None:
    """Let the arithmetic of the frames run while others are looked at."""
    if isinstance(signal.numbers, Planes) and signal.backend.jit:
        dr.eval(signal.numbers.words)


def await_bytes(signal: Signal) -> None:
    """Wait for the arithmetic of the frames, before that of others begins.

    Waiting is for all that has begun, so that it would be for the others as well.
    """
    if isinstance(signal.numbers, Planes) and signal.backend.jit:
        _ = signal.numbers.held
