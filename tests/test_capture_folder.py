"""Capture folders: what is written is read, and what lies is refused in one line."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from foundation.errors import InputError
from foundation.output import CHECKSUMS, new_folder
from foundation.panel import Panel
from sensor.camera_file import load
from sensor.capture_folder import MANIFEST, read_capture, write_capture
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import Protocol, Shot
from sensor.record import record
from sensor.truth import truth

HEIGHT, WIDTH = 24, 32
PROTOCOL = Protocol(
    name="short",
    shot=(
        Shot(label="dark", exposure_s=0.01, frames=3),
        Shot(label="lit", light=("lamp",), level=(0.5,), exposure_s=0.01, frames=5),
    ),
)
RATES = {"lamp": np.full((HEIGHT, WIDTH, 3), 1e5, np.float32)}
PANELS = (Panel(name="19", x=4, y=4, w=10, h=8),)


def small(name: str = "icx098"):
    return load(name).resized(HEIGHT, WIDTH)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    out = tmp_path / "capture"
    with new_folder(out) as scratch:
        write_capture(scratch, small(), PROTOCOL, RATES, seed=1, scene="chart", panels=PANELS)
    return out


def edit(folder: Path, old: str, new: str) -> None:
    path = folder / MANIFEST
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize("preset", ["icx098", "i400", "ideal"])
def test_what_is_written_is_read_and_equals_what_is_recorded_in_memory(
    preset: str, tmp_path: Path
) -> None:
    camera = small(preset)
    with new_folder(tmp_path / "c") as scratch:
        write_capture(scratch, camera, PROTOCOL, RATES, seed=1, scene="chart", panels=PANELS)
    read = read_capture(tmp_path / "c")
    memory = record(camera, PROTOCOL, RATES, seed=1, panels=PANELS)
    assert (read.camera, read.scene, read.panels) == (camera.name, "chart", PANELS)
    for a, b in zip(read.frames, memory.frames, strict=True):
        assert isinstance(a.dn, np.memmap)
        assert np.array_equal(a.dn, b.dn)
        assert (a.shot, a.pixels, a.bits, a.cfa) == (b.shot, b.pixels, b.bits, b.cfa)


def test_a_finished_folder_lists_its_checksums(folder: Path) -> None:
    lines = (folder / CHECKSUMS).read_text().splitlines()
    assert sorted(line.split("  ")[1] for line in lines) == [MANIFEST, "dark.npy", "lit.npy"]


def test_a_failure_while_writing_leaves_nothing(tmp_path: Path) -> None:
    broken = dataclasses.replace(
        PROTOCOL, shot=(*PROTOCOL.shot, Shot(label="x", light=("moon",), exposure_s=1, frames=2))
    )
    with pytest.raises(InputError, match="moon"), new_folder(tmp_path / "c") as scratch:
        write_capture(scratch, small(), broken, RATES, seed=1)
    assert list(tmp_path.iterdir()) == []


def test_frames_may_be_tiff_pages_or_a_series_of_images(folder: Path) -> None:
    stack = np.load(folder / "lit.npy")
    tifffile.imwrite(folder / "lit.tif", stack, photometric="rgb")
    for k, frame in enumerate(stack):
        Image.fromarray(frame).save(folder / f"lit-{k}.png")
    for name in ("lit.tif", "lit-*.png"):
        edit(folder, "lit.npy", name)
        assert np.array_equal(read_capture(folder).frames[1].dn, stack)
        edit(folder, name, "lit.npy")


@pytest.mark.parametrize("preset", ["ideal", "i400"])
@pytest.mark.parametrize("chunks", [(1, 1, 1, 1, 1), (1, 4), (3, 2)])
def test_every_page_of_a_tiff_is_a_frame_however_it_was_written(
    preset: str, chunks: tuple[int, ...], tmp_path: Path
) -> None:
    folder = tmp_path / "c"
    with new_folder(folder) as scratch:
        write_capture(scratch, small(preset), PROTOCOL, RATES, seed=1)
    stack = np.load(folder / "lit.npy")
    photometric = "rgb" if stack.ndim == 4 else "minisblack"
    edit(folder, "lit.npy", "lit.tif")
    ends = np.cumsum(chunks)
    parts = [stack[a] if b - a == 1 else stack[a:b] for a, b in zip([0, *ends], ends, strict=False)]
    with tifffile.TiffWriter(folder / "lit.tif", byteorder=">") as file:
        for part in parts:
            file.write(part, photometric=photometric)
    assert np.array_equal(read_capture(folder).frames[1].dn, stack)
    (folder / "lit.tif").unlink()
    for part in parts:
        tifffile.imwrite(folder / "lit.tif", part, photometric=photometric, append=True)
    assert np.array_equal(read_capture(folder).frames[1].dn, stack)


def test_a_series_of_fits_may_be_in_colour(folder: Path) -> None:
    from astropy.io import fits

    stack = np.load(folder / "lit.npy")
    for k, frame in enumerate(stack):
        fits.writeto(folder / f"lit-{k}.fits", np.moveaxis(frame, 2, 0))
    edit(folder, "lit.npy", "lit-*.fits")
    assert np.array_equal(read_capture(folder).frames[1].dn, stack)


def test_a_reduced_picture_beside_the_frames_of_a_tiff_is_no_frame(folder: Path) -> None:
    stack = np.load(folder / "lit.npy")
    with tifffile.TiffWriter(folder / "lit.tif") as file:
        file.write(stack, photometric="rgb")
        file.write(stack[0, ::2, ::2], photometric="rgb", subfiletype=1)
    edit(folder, "lit.npy", "lit.tif")
    assert np.array_equal(read_capture(folder).frames[1].dn, stack)


def unequal_pages(folder: Path) -> None:
    edit(folder, "lit.npy", "lit.tif")
    for height in (24, 20):
        page = np.zeros((height, WIDTH, 3), np.uint8)
        tifffile.imwrite(folder / "lit.tif", page, photometric="rgb", append=True)


def cut(name: str, keep: int):
    def spoil(folder: Path) -> None:
        path = folder / name
        path.write_bytes(path.read_bytes()[:keep])

    return spoil


def object_array(folder: Path) -> None:
    np.save(folder / "lit.npy", np.array([{}, {}], dtype=object), allow_pickle=True)


def link_out(folder: Path) -> None:
    (folder.parent / "secret.npy").write_bytes((folder / "lit.npy").read_bytes())
    (folder / "lit.npy").unlink()
    (folder / "lit.npy").symlink_to(folder.parent / "secret.npy")


def other_size(folder: Path) -> None:
    np.save(folder / "lit.npy", np.zeros((5, 10, 10, 3), np.uint8))


def floats(folder: Path) -> None:
    np.save(folder / "lit.npy", np.zeros((5, HEIGHT, WIDTH, 3)))


SPOILED = {
    "unknown key": (lambda f: edit(f, 'scene = "chart"', 'scen = "chart"'), "unknown key 'scen'"),
    "negative exposure": (lambda f: edit(f, "exposure_s = 0.01", "exposure_s = -1"), "exposure_s"),
    "text for a number": (lambda f: edit(f, "bits = 8", 'bits = "x"'), "bits"),
    "bits that do not fit": (lambda f: edit(f, "bits = 8", "bits = 12"), "bits = 12"),
    "values above the bits": (lambda f: edit(f, "bits = 8", "bits = 2"), "holds the value"),
    "wrong kind of pixel": (lambda f: edit(f, '"rgb8"', '"mono8"'), "shape"),
    "another format": (lambda f: edit(f, "capture/1", "capture/9"), "format"),
    "no TOML": (lambda f: edit(f, "bits = 8", "bits = = 8"), "not TOML"),
    "path with dots": (lambda f: edit(f, "lit.npy", "../lit.npy"), "leaves the capture folder"),
    "rate with dots": (
        lambda f: edit(f, 'frames = "lit.npy"', 'frames = "lit.npy", rate = "../rate.exr"'),
        "the path '../rate.exr' in",
    ),
    "glob of stacks": (lambda f: edit(f, "lit.npy", "*.npy"), "globs are for .png, .tif and .fits"),
    "no stack": (lambda f: (f / "lit.npy").write_bytes(b"abc" * 99), "not begin as a .npy file"),
    "absolute path": (lambda f: edit(f, '"lit.npy"', '"/etc/passwd"'), "leaves the capture"),
    "glob with dots": (lambda f: edit(f, "lit.npy", "../*.npy"), "leaves the capture folder"),
    "link out": (link_out, "leaves the capture folder"),
    "missing file": (lambda f: (f / "lit.npy").unlink(), "lit.npy"),
    "cut header": (cut("lit.npy", 20), "lit.npy"),
    "cut data": (cut("lit.npy", 500), "lit.npy"),
    "empty file": (cut("lit.npy", 0), "lit.npy"),
    "python objects": (object_array, "lit.npy"),
    "unequal size": (other_size, "10 x 10 pixels"),
    "unequal pages": (unequal_pages, "pages of shape (20, 32, 3)"),
    "floats": (floats, "float64"),
    "unknown ending": (lambda f: edit(f, "lit.npy", "lit.gif"), "lit.gif"),
    "bits in quotes": (lambda f: edit(f, "bits = 8", 'bits = "8"'), "expected a whole number"),
    "bits that are true": (lambda f: edit(f, "bits = 8", "bits = true"), "a whole number"),
    "a place in quotes": (lambda f: edit(f, "x = 4", 'x = "4"'), "expected a whole number"),
    "a mosaic of one colour": (lambda f: edit(f, "RGGB", "RRRR"), "one R, one B, and G twice"),
    "two reds": (lambda f: edit(f, "RGGB", "RRGB"), "one R, one B, and G twice"),
    "greens in a column": (lambda f: edit(f, "RGGB", "RGBG"), "G twice on a diagonal"),
    "same label": (lambda f: edit(f, 'label = "lit"', 'label = "dark"'), "two shots"),
    "panel outside": (lambda f: edit(f, "w = 10", "w = 1000"), "panel '19'"),
    "lights without levels": (
        lambda f: edit(f, 'light = "lamp"', 'light = ["a", "b"]'),
        "2 lights",
    ),
}


@pytest.mark.parametrize("case", SPOILED)
def test_a_spoiled_folder_is_refused_in_one_line(case: str, folder: Path) -> None:
    spoil, told = SPOILED[case]
    spoil(folder)
    with pytest.raises(InputError) as caught:
        read_capture(folder)
    text = str(caught.value)
    assert told in text
    assert "\n" not in text
    assert text.count(";") >= 2


def test_frames_larger_than_the_limit_are_refused_and_the_limit_can_be_set(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CAMTRUTH_MAX_PIXELS", "100")
    with pytest.raises(InputError, match="CAMTRUTH_MAX_PIXELS"):
        read_capture(folder)


def test_the_truth_record_tells_population_and_realised_values() -> None:
    camera = load("i400")
    record_ = truth(camera, PROTOCOL, 7)
    json.dumps(record_, allow_nan=False)
    noise = record_["noise"]
    assert noise["R"]["read"]["population"] == pytest.approx(1.612)
    assert noise["G"]["fpn"]["population"] == pytest.approx(0.123)
    assert noise["B"]["prnu_slope"]["population"] == pytest.approx(0.0128)
    assert noise["G"]["shot_coefficient"]["population"] == pytest.approx(0.515)
    sites = 640 * 480 / 4
    for key in ("fpn", "prnu"):
        entry = noise["R"][key]
        error = entry["population"] / np.sqrt(2 * sites)
        assert 0 < abs(entry["realised"] - entry["population"]) < 4.5 * error
    assert noise["R"]["read"]["realised"] == noise["R"]["read"]["population"]


def test_panels_set_side_by_side_keep_light_and_colour_phase() -> None:
    camera = load("i400")
    y, x = np.mgrid[:480, :640]
    rates = {"lamp": np.stack([x, y, x + y], axis=2).astype(np.float32)}
    panels = (Panel(name="a", x=33, y=77, w=50, h=50), Panel(name="b", x=200, y=101, w=50, h=50))
    small_camera, small_rates, moved = panels_only(camera, rates, panels)
    assert small_rates["lamp"].shape == (small_camera.height, small_camera.width, 3)
    for old, new in zip(panels, moved, strict=True):
        assert (old.x - new.x) % 2 == (old.y - new.y) % 2 == 0
        assert np.array_equal(rates["lamp"][old.window], small_rates["lamp"][new.window])
