"""A round trip's table is the same from one thread, from several, and from a cluster."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from camtruth.measuring import roundtrip
from foundation.panel import Panel
from render.rate import RateHeader, RateImage, rate_image
from sensor.camera_file import load
from sensor.protocol import Protocol, Shot
from tests.clusters import two_workers
from tests.conftest import Run, Small

PANELS = tuple(Panel(name=str(k), x=4 + 40 * k, y=8, w=30, h=30) for k in range(3))
PROTOCOL = Protocol(
    name="short",
    shot=(
        Shot(label="dark", exposure_s=0.03, frames=4),
        Shot(label="lit", light=("lamp",), exposure_s=0.03, frames=4),
    ),
)


def light() -> dict[str, RateImage]:
    rate = np.full((48, 128, 3), 1e5)
    rate[:, 40:] *= 2
    rate[:, 80:] *= 1.5
    return {"lamp": rate_image(rate, np.zeros_like(rate), RateHeader(scene="s", lamp="lamp"))}


def test_the_table_does_not_depend_on_who_computes_it(tmp_path: Path) -> None:
    camera = load("i400").resized(48, 128)
    words = {"seeds": range(8), "methods": ("irie", "emva1288"), "panels": PANELS}
    alone = roundtrip(camera, PROTOCOL, light(), threads=1, **words)
    assert len(alone) > 10
    assert roundtrip(camera, PROTOCOL, light(), threads=3, **words) == alone
    with two_workers(tmp_path) as cluster:
        assert roundtrip(camera, PROTOCOL, light(), scheduler=cluster.address, **words) == alone


def test_the_command_takes_a_scheduler(small: Small, run: Run) -> None:
    words = ("roundtrip", "--seeds", "2", "--protocol", small.protocol, *small.words)
    line = run(*words, "--scheduler", "nonsense").complaint
    assert "no answer from the scheduler nonsense" in line
