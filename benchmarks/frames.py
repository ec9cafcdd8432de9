"""A frame of 640 x 480: our chain against the plainest NumPy can do.

The NumPy chain draws a Poisson count and a normal for every pixel, scales, rounds and clips; it
has no fixed pattern and no demosaic. Ours is the sensor up to the digital code; once as plain a
camera, once the whole `i400` to finished 8-bit frames.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from foundation.backend import backend
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.catalogue import effect
from sensor.protocol import Shot
from sensor.record import take

FRAMES = 64
ELECTRONS = 4000.0
EXPOSURE_S = 0.03268
REPEATS = 3


def ratios() -> Iterator[tuple[str, float, float | None]]:
    whole = load("i400")
    plain = Camera(
        name="plain",
        pixels="bayer8",
        gain_dn_per_e=load("icx098").gain_dn_per_e,
        black_dn=3.0,
        effects=tuple(
            effect(name).with_parameters({})
            for name in ("photon_shot", "read_noise", "quantization")
        ),
    )
    slow = _best(_numpy_frames)
    promised = 10 if backend().jit else None
    for what, camera in (("shot and read noise, rounding", plain), ("the whole i400", whole)):
        fast = _best(lambda camera=camera: _ours(camera))
        per_frame = 1e3 * fast / FRAMES
        yield (
            f"faster frames ({what}): {per_frame:.2f} ms against {1e3 * slow / FRAMES:.2f} ms",
            slow / fast,
            promised if camera is plain else None,
        )


def _ours(camera: Camera) -> None:
    rate = np.full((camera.height, camera.width, 3), ELECTRONS / EXPOSURE_S, dtype=np.float32)
    shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=EXPOSURE_S, frames=FRAMES)
    for batch in take(camera, shot, {"lamp": rate}):
        assert batch.any()


def _numpy_frames() -> None:
    rng = np.random.default_rng(1)
    mean = np.full((480, 640), ELECTRONS)
    for _ in range(FRAMES):
        electrons = rng.poisson(mean) + rng.normal(0.0, 17.0, mean.shape)
        codes = np.clip(np.rint(electrons * 0.01515 + 3.0), 0, 255).astype(np.uint8)
        assert codes.any()


def _best(run: Callable[[], None]) -> float:
    """The shortest of a few runs in s, after one that compiles."""
    run()
    times = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        run()
        times.append(time.perf_counter() - started)
    return min(times)
