"""Captures larger than memory: chunk by chunk, the peak does not depend on the number of frames."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sensor import record
from tests.conftest import HEIGHT, WIDTH
from tests.test_public_face import ROOT

FEW, MANY = 64, 640
FRAME_BYTES = WIDTH * HEIGHT * 3
GROWTH_BYTES = (MANY - FEW) * FRAME_BYTES

CHILD = """
import sys
from pathlib import Path
from foundation.backend import backend
import numpy as np
from sensor import record
from sensor.camera_file import load
from sensor.capture_folder import write_capture
from sensor.protocol import Protocol, Shot

camera, frames, folder = load(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
record.BATCH_PIXELS = 16 * camera.width * camera.height
rate = np.full((camera.height, camera.width, 3), 1e5, np.float32)
shot = Shot(label="lit", light=("lamp",), exposure_s=0.03268, frames=frames)
protocol = Protocol(name="long", shot=(shot,))
if folder:
    write_capture(Path(folder), camera, protocol, {"lamp": rate}, seed=1)
else:
    kept = record.record(camera, protocol, {"lamp": rate}, seed=1)
# not ru_maxrss: that of a child is never below its parent's
status = Path("/proc/self/status").read_text().split("VmHWM:")[1]
print(1024 * int(status.split()[0]))
"""


def peak_bytes(camera: Path, frames: int, folder: Path | None, home: Path) -> int:
    """Peak of a process that records so many frames, whose compiled kernels are kept at home."""
    words = [sys.executable, "-c", CHILD, str(camera), str(frames), str(folder or "")]
    at_home = {**os.environ, "HOME": str(home)}
    run = subprocess.run(words, cwd=ROOT, env=at_home, capture_output=True, text=True, check=True)
    return int(run.stdout)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="Linux tells peak memory there")
def test_memory_does_not_grow_with_the_number_of_frames(small, tmp_path: Path) -> None:
    # whoever compiles takes 18 MB more; kernels of a shared cache may be gone when they are needed
    peak_bytes(small.camera, FEW, None, tmp_path)
    peaks = []
    for frames in (FEW, MANY):
        folder = tmp_path / str(frames)
        folder.mkdir()
        peaks.append(peak_bytes(small.camera, frames, folder, tmp_path))
        assert np.load(folder / "lit.npy", mmap_mode="r").shape == (frames, HEIGHT, WIDTH, 3)
    # a fifth of the frames' own size: what the allocators of two runs may differ by
    assert peaks[1] - peaks[0] < GROWTH_BYTES / 5
    # the same measurement does see frames that are kept
    assert peak_bytes(small.camera, MANY, None, tmp_path) - peaks[0] > GROWTH_BYTES / 2


def test_a_batch_has_as_many_pixels_whatever_the_shot(small) -> None:
    from sensor.camera_file import load
    from sensor.protocol import Shot

    camera = load(str(small.camera))
    for frames in (1, 255, 256, 257, 100_000):
        shot = Shot(label="a", exposure_s=0.01, frames=frames)
        found = list(record.batches(camera, shot))
        assert [k for batch in found for k in batch] == list(range(frames))
        assert max(map(len, found)) * WIDTH * HEIGHT <= record.BATCH_PIXELS
