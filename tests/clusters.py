"""A Dask scheduler and two workers on loopback, each a process of its own, to be killed at will."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PATIENCE_S = 60
QUIET = ("--no-dashboard", "--host", "127.0.0.1")


UNWATCHED = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
"""As docs/exchange.md has it for workers that others begin."""


@dataclass(frozen=True, kw_only=True)
class Cluster:
    address: str
    workers: list[subprocess.Popen[bytes]]


def start(*words: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", *words],
        env={**os.environ, **UNWATCHED, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@contextlib.contextmanager
def two_workers(folder: Path, count: int = 2) -> Iterator[Cluster]:
    """A cluster whose workers are there before the block begins; gone when it ends."""
    from distributed import Client

    file = folder / "scheduler.json"
    running = [
        start("distributed.cli.dask_scheduler", "--port=0", "--scheduler-file", str(file), *QUIET)
    ]
    try:
        until = time.monotonic() + PATIENCE_S
        while not file.exists() or not file.read_text():
            assert time.monotonic() < until, "no scheduler"
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        apart = ("--no-nanny", "--nthreads=1", "--local-directory", str(folder), *QUIET)
        running += [start("distributed.cli.dask_worker", address, *apart) for _ in range(count)]
        with Client(address) as client:
            client.wait_for_workers(count, timeout=PATIENCE_S)
        yield Cluster(address=address, workers=running[1:])
    finally:
        for process in running:
            process.kill()
            process.wait()
