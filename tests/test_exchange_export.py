"""What is exported, the libraries of others read: the same pixels, bit for bit, and the truth."""

from __future__ import annotations

import csv
import dataclasses
import json
import logging
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from camtruth.exchange.format import formats
from camtruth.simulating import capture_to
from foundation.output import CHECKSUMS, new_folder
from render.closed_form import render
from render.rate import RateHeader, rate_image
from scenes.scene import load as load_scene
from sensor.camera import Camera
from sensor.capture_folder import read_capture, read_manifest, write_manifest
from sensor.catalogue import effect
from sensor.colours import Colours
from sensor.protocol import Protocol, Shot
from tests.conftest import Run
from tests.peers import PEERS, PROTOCOL, Stack

HEIGHT, WIDTH = 46, 64
KINDS = {"rgb8": 8, "bayer8": 8, "bayer16": 12, "mono8": 8, "mono16": 16}


def camera(kind: str) -> Camera:
    bits = KINDS[kind]
    names = ["prnu", "photon_shot", "fpn", "read_noise", "quantization"]
    names += ["demosaic"] if kind == "rgb8" else []
    plain = Camera(
        name="peer",
        width=WIDTH,
        height=HEIGHT,
        pixels=kind,  # type: ignore[arg-type]
        bits=bits,
        cfa="GGGG" if kind.startswith("mono") else "GRBG",
        gain_dn_per_e=Colours.of(0.015 * 2 ** (bits - 8)),
        black_dn=3.0 * 2 ** (bits - 8),
    )
    return plain.plus(*(effect(name).with_parameters({}) for name in names))


@pytest.fixture(scope="module")
def captures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A capture of the chart for every kind of pixel."""
    light = {"incandescent": render(load_scene("chart").with_size(WIDTH, HEIGHT), "incandescent")}
    folder = tmp_path_factory.mktemp("captures")
    for kind in KINDS:
        with new_folder(folder / kind) as scratch:
            capture_to(scratch, camera(kind), PROTOCOL, light, seed=5, scene="chart")
    return {kind: folder / kind for kind in KINDS}


@pytest.mark.parametrize(("name", "read"), PEERS, ids=lambda v: v if isinstance(v, str) else "")
def test_a_peer_reads_the_same_pixels(
    name: str, read: Callable[[Path, str], Stack], captures: dict[str, Path], run: Run
) -> None:
    for kind in formats()[name].pixels:
        out = Path("out") / kind
        assert run("export", captures[kind], "--format", name, "--out", out).code == 0
        for frames in read_capture(captures[kind]).frames:
            stack = read(out, frames.shot.label)
            assert stack.shape == frames.dn.shape, kind
            assert np.array_equal(stack, frames.dn), kind


@pytest.mark.parametrize("name", [n for n, f in formats().items() if f.native])
def test_formats_that_a_capture_may_hold_are_captures(
    name: str, captures: dict[str, Path], run: Run
) -> None:
    for kind in ("rgb8", "bayer16"):
        run("export", captures[kind], "--format", name, "--out", kind)
        here, there = read_capture(Path(kind)), read_capture(captures[kind])
        assert (here.camera, here.scene, here.panels) == (there.camera, there.scene, there.panels)
        for a, b in zip(here.frames, there.frames, strict=True):
            assert a.shot == b.shot
            assert np.array_equal(a.dn, b.dn)


@pytest.mark.parametrize("name", sorted(formats()))
def test_an_export_is_whole_tells_everything_and_is_the_same_again(
    name: str, captures: dict[str, Path], run: Run
) -> None:
    kind = "bayer16"
    answer = run("export", captures[kind], "--format", name, "--out", "a", "--json")
    told = json.loads(answer.out)
    assert (told["format"], told["licence"]) == ("camtruth-export/1", "CC0-1.0")
    assert run("verify", "a").code == 0
    checked = subprocess.run(
        ["sha256sum", "--check", "--strict", "--quiet", CHECKSUMS], cwd="a", check=False
    )
    assert checked.returncode == 0
    run("export", captures[kind], "--format", name, "--out", "b")
    assert Path("a", CHECKSUMS).read_bytes() == Path("b", CHECKSUMS).read_bytes()

    assert Path("a/truth.json").read_bytes() == (captures[kind] / "truth.json").read_bytes()
    assert Path("a/rate-incandescent.exr").exists()
    assert "SPDX-License-Identifier: CC0-1.0" in Path("a/LICENSE.txt").read_text()
    with Path("a/frames.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == told["frames"]
    for row in rows:
        assert Path("a", row["file"]).exists()
        shot = next(shot for shot in PROTOCOL.shot if shot.label == row["shot"])
        assert float(row["exposure_s"]) == shot.exposure_s
        assert int(row["frame"]) < shot.frames
    if name not in ("exr", "emva1288"):
        assert len(rows) == sum(shot.frames for shot in PROTOCOL.shot)
        shots = "capture.toml" if formats()[name].native else "shots.toml"
        assert tomllib.loads(Path("a", shots).read_text())["cfa"] == "GRBG"


def test_the_dataset_card_is_croissant(captures: dict[str, Path], run: Run) -> None:
    run("export", captures["rgb8"], "--format", "npy", "--out", "a", "--licence", "CC-BY-4.0")
    card = json.loads(Path("a/croissant.json").read_text())
    assert card["@type"] == "sc:Dataset"
    assert card["conformsTo"] == "http://mlcommons.org/croissant/1.0"
    assert card["license"] == "https://spdx.org/licenses/CC-BY-4.0.html"
    sums = dict(line.split("  ")[::-1] for line in Path("a", CHECKSUMS).read_text().splitlines())
    files = [entry for entry in card["distribution"] if entry["@type"] == "cr:FileObject"]
    assert {entry["contentUrl"] for entry in files} >= {"frames.csv", "truth.json", "README.md"}
    for entry in files:
        if "sha256" in entry and entry["contentUrl"] in sums:
            assert entry["sha256"] == sums[entry["contentUrl"]]
    with Path("a/frames.csv").open() as stream:
        columns = next(csv.reader(stream))
    assert [field["name"] for field in card["recordSet"][0]["field"]] == columns


def test_the_maps_are_the_light_and_the_pattern_of_this_body(
    captures: dict[str, Path], run: Run
) -> None:
    """The mean of many frames of a camera is its maps, put together as the README says."""
    light = {"lamp": rate_image(np.full((30, 40, 3), 3e5), np.zeros((30, 40, 3)), HEADER)}
    body = camera("mono16").resized(30, 40).with_body(7)
    body = body.plus(effect("fpn").with_parameters({"sigma_e": 200.0}))
    shots = Protocol(
        name="long",
        shot=(Shot(label="lit", light=("lamp",), exposure_s=0.03, frames=400),),
    )
    with new_folder(Path("made")) as scratch:
        capture_to(scratch, body, shots, light, seed=1)
    run("export", "made", "--format", "npy", "--out", "out")
    truth = json.loads(Path("out/truth.json").read_text())
    electrons = np.load("out/truth/electrons-lit.npy").astype(np.float64)
    response = np.load("out/truth/response-prnu.npy")
    offset = np.load("out/truth/offset-fpn.npy")
    gain, black = truth["gain_dn_per_e"], truth["black_dn"]
    expected = gain * (electrons * response + offset) + black
    frames = np.load("out/frames/lit.npy").astype(np.float64)
    error = frames.std(axis=0, ddof=1) / np.sqrt(len(frames))
    z = (frames.mean(axis=0) - expected) / error
    # 1200 pixels: |z| of all of them, and the scatter of z as Student's t with 399 degrees has it
    assert np.abs(z).max() < 5.5
    assert abs(z.std() - 1) < 4.5 / np.sqrt(2 * z.size)
    assert electrons == pytest.approx(9000.0)
    assert abs(offset.std() / 200 - 1) < 4.5 / np.sqrt(2 * offset.size)


HEADER = RateHeader(scene="flat", lamp="lamp")


@pytest.mark.filterwarnings("ignore:Exception ignored in.*emva1288.txt")  # it leaves its file open
def test_the_emva1288_package_finds_gain_dsnu_and_prnu(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reader with the exported folder and a peer's tool alone: the truth record's figures.

    emva1288 1.0.2 still calls `numpy.asfarray`, which NumPy 2 took away; it gets it back here.
    """
    monkeypatch.setattr(np, "asfarray", lambda a: np.asarray(a, dtype=float), raising=False)
    peer = pytest.importorskip("emva1288.process")
    logging.disable(logging.CRITICAL)
    side, frames = 160, 16
    light = {"lamp": rate_image(np.full((side, side, 3), 1e6), np.zeros((side, side, 3)), HEADER)}
    body = camera("mono16").resized(side, side)
    figures = {
        "prnu": {"ratio": 0.02},
        "fpn": {"sigma_e": 30.0},
        "read_noise": {"reset_e": 0.0, "thermal_e": 20.0, "other_e": 0.0},
    }
    body = body.plus(*(effect(name).with_parameters(known) for name, known in figures.items()))
    levels = np.linspace(0.05, 1.45, 15)
    shots = Protocol(
        name="photon transfer",
        shot=(
            Shot(label="dark", exposure_s=0.012, frames=frames),
            *(
                Shot(
                    label=f"lit-{k:02d}",
                    light=("lamp",),
                    level=(float(level),),
                    exposure_s=0.012,
                    frames=frames,
                )
                for k, level in enumerate(levels)
            ),
        ),
    )
    with new_folder(Path("made")) as scratch:
        capture_to(scratch, body, shots, light, seed=2)
    assert run("export", "made", "--format", "emva1288", "--out", "out").code == 0
    parsed = peer.ParseEmvaDescriptorFile("out/frames/Y/emva1288.txt")
    data = peer.Data1288(peer.LoadImageData(parsed.images).data).data
    found = peer.Results1288(data)
    logging.disable(logging.NOTSET)

    noise = json.loads(Path("out/truth.json").read_text())["noise"]["Y"]
    truth = {key: entry["population"] for key, entry in noise.items()}
    n = side * side
    used = slice(found.index_sensitivity_min, found.index_sensitivity_max + 1)
    x = (found.temporal["u_y"] - found.temporal["u_ydark"])[used]
    # two images give a variance from n differences: relative standard error sqrt(2/n)
    se_y = np.hypot(found.temporal["s2_y"][used], found.temporal["s2_ydark"][used]) * np.sqrt(2 / n)
    gain_se = np.sqrt(np.sum(x**2 * se_y**2)) / np.sum(x**2)
    assert x.size >= 8
    assert abs(found.K - truth["gain"]) < 4.5 * gain_se
    assert gain_se / truth["gain"] < 0.01
    # a standard deviation over n photosites: 1/sqrt(2n), a little more for what frames leave
    dsnu_se = found.s_2_y_measured_dark / found.DSNU1288_DN() / np.sqrt(2 * n)
    assert abs(found.DSNU1288_DN() - truth["dsnu"]) < 4.5 * dsnu_se
    signal = found.spatial["avg_mean"] - found.spatial["avg_mean_dark"]
    spread = np.hypot(found.s_2_y_measured, found.s_2_y_measured_dark)
    prnu_se = spread / np.sqrt(2 * n) / (found.PRNU1288 / 100) / signal**2
    assert abs(found.PRNU1288 / 100 - truth["prnu"]) < 4.5 * prnu_se
    assert max(dsnu_se / truth["dsnu"], prnu_se / truth["prnu"]) < 0.02


def test_exr_is_the_rate_image(captures: dict[str, Path], run: Run) -> None:
    import OpenEXR

    from render.rate import read_rate

    run("export", captures["rgb8"], "--format", "exr", "--out", "out")
    file = Path("out/frames/rate-incandescent.exr")
    ours = read_rate(file).rate_e_per_s
    with OpenEXR.File(str(file), separate_channels=True) as opened:
        for k, channel in enumerate("RGB"):
            assert np.array_equal(opened.channels()[channel].pixels, ours[..., k])


REFUSED = {
    "unknown format": (("--format", "gif"), "unknown format 'gif'"),
    "no format": ((), "--format"),
    "dng of colours": (("--format", "dng"), "bayer8 or bayer16"),
    "no licence at all": (("--format", "npy", "--licence", "my own!"), "SPDX"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals(case: str, captures: dict[str, Path], run: Run) -> None:
    words, told = REFUSED[case]
    assert told in run("export", captures["rgb8"], *words).complaint
    assert not Path("camtruth-out").exists()


def real(capture: Path) -> Path:
    """The frames of a capture, without what only a simulation knows."""
    out = Path("real")
    out.mkdir()
    for frames in read_capture(capture).frames:
        np.save(out / f"{frames.shot.label}.npy", frames.dn)
    manifest = read_manifest(capture)
    shots = tuple(dataclasses.replace(shot, rate=None) for shot in manifest.shot)
    write_manifest(out, dataclasses.replace(manifest, shot=shots))
    return out


def test_a_real_capture_has_a_licence_that_somebody_states_and_no_truth(
    captures: dict[str, Path], run: Run
) -> None:
    folder = real(captures["mono8"])
    assert "--licence" in run("export", folder, "--format", "png").complaint
    words = ("--licence", "CC-BY-4.0", "--out", "out")
    assert run("export", folder, "--format", "png", *words).code == 0
    assert not Path("out/truth.json").exists()
    assert not Path("out/truth").exists()
    assert "no truth record" in Path("out/README.md").read_text()
    for name in ("exr", "emva1288"):
        assert "rate image" in run("export", folder, "--format", name, *words[:2]).complaint


def test_a_missing_library_is_one_line(
    captures: dict[str, Path], run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    line = run("export", captures["rgb8"], "--format", "ffv1").complaint
    assert "no library 'av'" in line
    assert "pip install" in line
    assert not Path("camtruth-out/export").exists()
