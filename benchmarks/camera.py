"""A frame of 640 x 480 of the whole base camera, to 8-bit colour, against all who make the same.

All contenders take turns in one run, and the shortest turn of each counts: what else the machine
does then hits all alike. See docs/speed.md for what the figures mean.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peers import ELECTRONS, EXPOSURE_S, PEERS, missing, plain_numpy
from foundation.backend import backend
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.catalogue import effect
from sensor.planes import Planes
from sensor.protocol import Shot
from sensor.record import batches, take
from sensor.signal import Quantity
from sensor.simulation import exposed, lit
from sensor.stream import Stream

ROUNDS = 5
PEER_FRAMES = 4
FRAMES = {"cuda": 256, "llvm": 128, "scalar": 8}
TARGET_MS = 1.0
PROMISED_FASTER = {"cuda": 10.0, "llvm": 10.0, "scalar": 0.1}


def ratios() -> Iterator[tuple[str, float, float | None]]:
    name = backend().name
    base, bare = load("icx098"), mosaic_camera()
    ours = FRAMES[name]
    contenders: dict[str, tuple[int, Callable[[], None]]] = {
        "ours": (ours, lambda: frames_of(base, ours)),
        "without colours": (ours, lambda: frames_of(bare, ours)),
        "limit": (ours, lambda: random_numbers(ours)),
        "plain NumPy": (PEER_FRAMES, repeated(plain_numpy())),
    }
    for peer, make in PEERS.items():
        if missing(make):
            print(f"{'':12}  {peer} is not installed: 'pip install --group bench' compares with it")
        else:
            contenders[peer] = (PEER_FRAMES, repeated(make()))
    best = in_turns(contenders)
    fast = best.pop("ours")
    plain, limit = best.pop("without colours"), best.pop("limit")
    yield (
        f"of {TARGET_MS:g} ms: base camera to 8-bit colour, {fast.wall:.2f} ms a frame,"
        f" {fast.cpu:.2f} ms of processors",
        TARGET_MS / fast.wall,
        None,
    )
    for other, slow in best.items():
        what = f"the speed of {other}: {fast.wall:.2f} ms a frame against {slow.wall:.1f} ms"
        yield what, slow.wall / fast.wall, PROMISED_FASTER[name]
        what = f"the same by time of processors: {fast.cpu:.2f} ms against {slow.cpu:.1f} ms"
        yield what, slow.cpu / fast.cpu, None
    what = "of its time of processors: the same without colours"
    yield f"{what}, {plain.cpu:.2f} ms", plain.cpu / fast.cpu, None
    what = "of its time of processors: two normal numbers a pixel"
    yield f"{what}, {limit.cpu:.2f} ms", limit.cpu / fast.cpu, None


def mosaic_camera() -> Camera:
    """Shot noise, read noise and rounding, and nothing else."""
    kinds = ("photon_shot", "read_noise", "quantization")
    return Camera(
        name="plain",
        pixels="bayer8",
        gain_dn_per_e=load("icx098").gain_dn_per_e,
        black_dn=3.0,
        effects=tuple(effect(kind).with_parameters({}) for kind in kinds),
    )


def frames_of(camera: Camera, frames: int) -> None:
    """Take frames of even grey and let them go."""
    rate = np.full((camera.height, camera.width, 3), ELECTRONS / EXPOSURE_S, dtype=np.float32)
    shot = Shot(label="lit", light=("lamp",), exposure_s=EXPOSURE_S, frames=frames)
    for batch in take(camera, shot, {"lamp": rate}):
        assert batch[0, 0, 0].any()


def random_numbers(frames: int) -> None:
    """Two normal numbers for every pixel, drawn in batches like a camera's, and nothing else."""
    import drjit as dr

    camera, shot = mosaic_camera(), Shot(label="dark", exposure_s=EXPOSURE_S, frames=frames)
    sensor = exposed(
        camera, lit(camera, shot, {}, backend()), range(1), seed=1, until=Quantity.RATE
    )
    mosaic = sensor.replace(backend().tensor(np.zeros((1, camera.height, camera.width))))
    for batch in batches(camera, shot):
        total: Any = 0.0
        for name in ("photon_shot", "read_noise"):
            stream = Stream(
                backend=backend(), seed=1, body_seed=0, effect=name, shot="lit", frames=batch
            )
            drawn = stream.noise(mosaic)
            parts = drawn.colours[0] if isinstance(drawn, Planes) else (drawn.array,)
            total = sum(parts, start=total)
        dr.eval(total)
        dr.sync_thread()


def repeated(frame: Callable[[], Any]) -> Callable[[], None]:
    """Make `PEER_FRAMES` frames."""

    def run() -> None:
        for _ in range(PEER_FRAMES):
            assert frame().shape == (480, 640, 3)

    return run


class Turn(NamedTuple):
    """What a frame took at best, in ms."""

    wall: float
    cpu: float
    """Of all threads together: what a machine that is busy otherwise can measure."""


def in_turns(contenders: dict[str, tuple[int, Callable[[], None]]]) -> dict[str, Turn]:
    """The shortest times of each, after a turn that compiles."""
    best = dict.fromkeys(contenders, Turn(float("inf"), float("inf")))
    for turn in range(ROUNDS + 1):
        for name, (frames, run) in contenders.items():
            wall, cpu = time.perf_counter(), time.process_time()
            run()
            cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
            if turn:
                so_far = best[name]
                best[name] = Turn(
                    min(so_far.wall, 1e3 * wall / frames), min(so_far.cpu, 1e3 * cpu / frames)
                )
    return best
