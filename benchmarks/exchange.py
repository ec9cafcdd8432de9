"""Frames out: each format against the plainest use of its own library, 640 x 480 RGB of `i400`.

Both sides read the same frames and write them, in turn, and the shortest of five runs counts, in
time of processors: that of the disk is the same for both, and on a shared machine anybody's. Ours
is what writes the frames; the frames a second of whole exports, with checksums, truth and card, are
told by the clock for the two raw formats. Then two workers against one on a dataset: processes of
one thread on loopback; the same bytes.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from astropy.io import fits
from PIL import Image

from camtruth.dataset.make import make
from camtruth.dataset.plan import plan
from camtruth.dataset.spec import read_spec
from camtruth.exchange.export import export, prepare
from camtruth.exchange.format import formats
from camtruth.exchange.source import Source, read_source
from foundation.cores import cores
from foundation.output import new_folder
from sensor.camera_file import load
from sensor.capture_folder import write_capture
from sensor.catalogue import effect
from sensor.protocol import Protocol, Shot
from tests.clusters import two_workers

FRAMES = {"png": 12, "ffv1": 48}
MANY = 240
RUNS = 5
PROMISED_PER_S = 300.0
SLOWER = 1 / 1.3
FASTER = 1.7
MOST_MB = 1000.0

Stack = np.ndarray[Any, Any]


def ratios() -> Iterator[tuple[str, float, float | None]]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, count in (("npy", MANY), ("zarr", MANY)):
            per_s = _whole(folder, kind, count)
            what = f"frames/s exported whole as {kind}: {per_s:.0f} against {PROMISED_PER_S:.0f}"
            yield what, per_s / PROMISED_PER_S, 1.0
        for kind, plain in PLAIN.items():
            count = FRAMES.get(kind, MANY)
            if kind == "dng":
                yield _against(folder, kind, plain, _capture(folder / "raw", "bayer8", count))
                continue
            yield _against(folder, kind, plain, _capture(folder / kind, "rgb8", count))
    yield from _cluster()


def _capture(folder: Path, pixels: str, count: int) -> Source:
    camera = load("i400")
    if pixels != "rgb8":
        kept = [e for e in camera.effects if e.name != "demosaic"]
        camera = camera.without(effect("demosaic"))
        camera = type(camera)(**{**vars(camera), "pixels": pixels, "effects": tuple(kept)})
    shots = Protocol(
        name="bench", shot=(Shot(label="lit", light=("lamp",), exposure_s=0.03, frames=count),)
    )
    rate = np.full((camera.height, camera.width, 3), 1e5, dtype=np.float32)
    with new_folder(folder) as scratch:
        write_capture(scratch, camera, shots, {"lamp": rate}, seed=1)
    return read_source(folder)


def _whole(folder: Path, kind: str, count: int) -> float:
    source = _capture(folder / f"whole-{kind}", "rgb8", count)
    _, chosen, licence = prepare(source.folder, kind, "CC0-1.0")
    times = []
    for run in range(3):
        started = time.perf_counter()
        with new_folder(folder / f"out-{kind}-{run}") as scratch:
            export(scratch, source, chosen, licence)
        times.append(time.perf_counter() - started)
    return count / min(times)


def _against(
    folder: Path, kind: str, plain: Callable[[Path, Stack], None], source: Source
) -> tuple[str, float, float | None]:
    stack = source.capture.frames[0].dn
    write = formats()[kind].write
    ours, theirs = [], []
    for run in range(RUNS):
        for times, name, writer in (
            (theirs, "theirs", lambda home: plain(home, stack)),
            (ours, "ours", lambda home: list(write(home, source))),
        ):
            home = folder / f"{kind}-{name}-{run}"
            home.mkdir()
            started = time.process_time()
            writer(home)
            times.append(time.process_time() - started)
            shutil.rmtree(home)
    per_s = [len(stack) / min(times) for times in (ours, theirs)]
    what = (
        f"the speed of {kind}'s own library: {per_s[0]:.0f} frames a second of processor"
        f" against {per_s[1]:.0f}"
    )
    return what, per_s[0] / per_s[1], SLOWER


def _png(home: Path, stack: Stack) -> None:
    for k, frame in enumerate(stack):
        Image.fromarray(frame).save(home / f"{k}.png")


def _tiff(home: Path, stack: Stack) -> None:
    for k, frame in enumerate(stack):
        tifffile.imwrite(home / f"{k}.tif", frame, photometric="rgb")


def _pages(home: Path, stack: Stack) -> None:
    tifffile.imwrite(home / "x.tif", stack, photometric="rgb")


def _dng(home: Path, stack: Stack) -> None:
    for k, frame in enumerate(stack):
        tifffile.imwrite(home / f"{k}.tif", frame, photometric="minisblack")


def _fits(home: Path, stack: Stack) -> None:
    fits.PrimaryHDU(np.ascontiguousarray(np.moveaxis(stack, 3, 1))).writeto(home / "x.fits")


def _npy(home: Path, stack: Stack) -> None:
    np.save(home / "x.npy", stack)


def _zarr(home: Path, stack: Stack) -> None:
    import zarr

    chunks = (16, *stack.shape[1:])
    zarr.create_array(
        str(home / "x.zarr"),
        data=stack,
        chunks=chunks,
        compressors=None,
        config={"write_empty_chunks": True},  # its fast way: chunks are not searched for zeros
    )


def _ffv1(home: Path, stack: Stack) -> None:
    import av

    with av.open(str(home / "x.mkv"), "w") as file:
        stream = file.add_stream("ffv1", rate=15)
        stream.width, stream.height, stream.pix_fmt = stack.shape[2], stack.shape[1], "bgr0"
        for frame in stack:
            picture = av.VideoFrame.from_ndarray(frame, format="rgb24")
            file.mux(stream.encode(picture.reformat(format="bgr0")))
        file.mux(stream.encode(None))


PLAIN: dict[str, Callable[[Path, Stack], None]] = {
    "png": _png,
    "tiff": _tiff,
    "tiff-pages": _pages,
    "dng": _dng,
    "fits": _fits,
    "npy": _npy,
    "zarr": _zarr,
    "ffv1": _ffv1,
}

SPEC = """format = "camtruth-dataset/1"
name = "bench"
cameras = ["i400"]
bodies = {bodies}
lamps = ["incandescent"]
levels = [0.25, 0.5, 1.0]
exposures_s = [0.03]
frames = 32
renderer = "closed-form"
size = [320, 240]
"""


def _cluster() -> Iterator[tuple[str, float, float | None]]:
    count = cores()
    took, rss = {}, 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for bodies in (16, 72):
            (folder / f"{bodies}.toml").write_text(SPEC.format(bodies=bodies), encoding="utf-8")
        for workers in (1, 2):
            home = folder / f"cluster-{workers}"
            home.mkdir()
            with two_workers(home, workers) as cluster:
                warm, real = (plan(read_spec(folder / f"{bodies}.toml")) for bodies in (16, 72))
                make(home / "warm", warm, scheduler=cluster.address)
                started = time.perf_counter()
                make(home / "set", real, scheduler=cluster.address)
                took[workers] = time.perf_counter() - started
                rss = max([rss, *(_resident_mb(worker) for worker in cluster.workers)])
    what = (
        f"faster with two workers than with one: {real.frames / took[2]:.0f} frames/s against"
        f" {real.frames / took[1]:.0f}, on {count} cores"
    )
    yield what, took[1] / took[2], FASTER if count >= 2 else None
    if rss:
        yield f"times a worker's memory ({rss:.0f} MB) in 1 GB", MOST_MB / rss, 1.0


def _resident_mb(process: subprocess.Popen[bytes]) -> float:
    """Largest memory that a process ever held, where the system tells."""
    status = Path(f"/proc/{process.pid}/status")
    if sys.platform != "linux" or not status.exists():
        return 0.0
    line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024
