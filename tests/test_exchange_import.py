"""What others wrote comes in as it was, and nothing that is not stated is guessed."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from PIL import Image

from camtruth.exchange.format import formats
from foundation.output import sha256
from sensor.capture_folder import read_capture
from tests.conftest import Run
from tests.test_exchange_export import captures

__all__ = ["captures"]

RNG = np.random.default_rng(8)
GREY = RNG.integers(0, 256, (4, 20, 30), dtype=np.uint8)
DEEP = RNG.integers(0, 4096, (4, 20, 30), dtype=np.uint16)
COLOUR = RNG.integers(0, 256, (4, 20, 30, 3), dtype=np.uint8)
ANSWERS = ("--exposure", "*=0.02", "--light", "*=lamp@0.5", "--camera", "mine")

Stack = np.ndarray[Any, Any]


def imported(out: str | Path = "camtruth-out/import") -> dict[str, Stack]:
    return {frames.shot.label: np.asarray(frames.dn) for frames in read_capture(Path(out)).frames}


@pytest.mark.parametrize("name", [n for n, f in formats().items() if f.stack])
def test_what_was_exported_comes_back_whole(name: str, captures: dict[str, Path], run: Run) -> None:
    for kind in formats()[name].pixels:
        run("export", captures[kind], "--format", name, "--out", f"out-{kind}")
        answer = run("import", f"out-{kind}", "--out", f"in-{kind}", "--json")
        assert (answer.code, answer.err) == (0, ""), answer
        assert json.loads(answer.out)["pixels"] == kind
        here, there = read_capture(Path(f"in-{kind}")), read_capture(captures[kind])
        assert (here.camera, here.scene, here.panels) == (there.camera, there.scene, there.panels)
        for a, b in zip(here.frames, there.frames, strict=True):
            assert (a.shot, a.bits, a.cfa) == (b.shot, b.bits, b.cfa)
            assert np.array_equal(a.dn, b.dn)
        assert (Path(f"in-{kind}") / "truth.json").read_bytes() == (
            captures[kind] / "truth.json"
        ).read_bytes()
        assert run("verify", f"in-{kind}").code == 0


def exif(seconds: float, model: str) -> Image.Exif:
    tags = Image.Exif()
    tags[272] = model
    tags.get_ifd(34665)[33434] = seconds
    return tags


def write_pngs(folder: Path, stack: Stack, seconds: float | None = None) -> None:
    folder.mkdir(parents=True)
    for k, frame in enumerate(stack):
        told = {} if seconds is None else {"exif": exif(seconds, "Model X")}
        Image.fromarray(frame).save(folder / f"{k}.png", **told)


def test_exposures_and_camera_come_from_exif(run: Run) -> None:
    write_pngs(Path("frames/dark"), COLOUR, 0.004)
    write_pngs(Path("frames/lit"), COLOUR, 0.02)
    words = ("import", "frames", "--light", "dark=none", "--light", "lit=a@0.5,b")
    assert run(*words).code == 0
    capture = read_capture(Path("camtruth-out/import"))
    assert capture.camera == "Model X"
    shots = {frames.shot.label: frames.shot for frames in capture.frames}
    assert shots["dark"].exposure_s == pytest.approx(0.004)
    assert (shots["lit"].light, shots["lit"].level) == (("a", "b"), (0.5, 1.0))
    record = json.loads(Path("camtruth-out/import/import.json").read_text())
    entry = record["shots"][1]
    assert entry["said_by"] == {"exposure_s": "EXIF", "light": "option"}
    assert entry["files"][0] == {
        "name": "lit/0.png",
        "sha256": sha256(Path("frames/lit/0.png")),
    }


def test_an_option_that_differs_from_the_header_is_taken_and_said(run: Run) -> None:
    write_pngs(Path("frames/lit"), COLOUR, 0.02)
    answer = run("import", "frames", "--light", "*=lamp", "--exposure", "lit=0.03")
    assert answer.code == 0
    assert "EXIF says 0.02 s, --exposure 0.03 s" in answer.err
    assert read_capture(Path("camtruth-out/import")).frames[0].shot.exposure_s == 0.03


def test_tiff_fits_and_npy(run: Run) -> None:
    from astropy.io import fits

    frames = Path("frames")
    (frames / "single").mkdir(parents=True)
    for k, frame in enumerate(DEEP):
        tags = [(33434, 5, 1, (1, 50), True)]
        tifffile.imwrite(frames / "single" / f"{k}.tif", frame, extratags=tags)
    cube = fits.PrimaryHDU(DEEP)
    cube.header["EXPOSURE"], cube.header["CCD-TEMP"] = 0.05, -10.5
    cube.writeto(frames / "cube.fits")
    np.save(frames / "stack.npy", DEEP)
    (frames / "notes.txt").write_text("hello")
    words = ("import", "frames", "--light", "*=lamp", "--camera", "mine", "--bits", "12")
    line = run(*words, "--cfa", "none").complaint
    assert "pass --exposure stack=SECONDS" in line
    answer = run(*words, "--cfa", "none", "--exposure", "stack=0.1")
    assert answer.code == 0
    assert "left aside: notes.txt" in answer.err
    capture = read_capture(Path("camtruth-out/import"))
    exposures = {f.shot.label: f.shot.exposure_s for f in capture.frames}
    assert exposures == pytest.approx({"cube": 0.05, "single": 0.02, "stack": 0.1})
    assert capture.frames[0].shot.temperature_c == -10.5
    assert all(np.array_equal(f.dn, DEEP) for f in capture.frames)
    assert {(f.pixels, f.bits) for f in capture.frames} == {("mono16", 12)}


def test_video_is_grey_as_stored_or_rgb_and_a_conversion_is_said(run: Run) -> None:
    av = pytest.importorskip("av")

    def encode(name: str, stack: Stack, given: str, codec: str, stored: str) -> None:
        with av.open(name, "w") as file:
            stream = file.add_stream(codec, rate=25)
            stream.width, stream.height, stream.pix_fmt = 30, 20, stored
            for frame in stack:
                picture = av.VideoFrame.from_ndarray(frame, format=given)
                file.mux(stream.encode(picture.reformat(format=stored)))
            file.mux(stream.encode(None))

    Path("a").mkdir()
    encode("a/deep.mkv", DEEP, "gray12le", "ffv1", "gray12le")
    assert run("import", "a", *ANSWERS, "--cfa", "RGGB", "--out", "in-a").code == 0
    capture = read_capture(Path("in-a"))
    assert (capture.frames[0].pixels, capture.frames[0].bits) == ("bayer16", 12)
    assert np.array_equal(capture.frames[0].dn, DEEP)

    Path("b").mkdir()
    encode("b/yuv.mkv", COLOUR, "rgb24", "ffv1", "yuv420p")
    answer = run("import", "b", *ANSWERS, "--out", "in-b")
    assert "yuv420p to rgb24" in answer.err
    with av.open("b/yuv.mkv") as file:
        expected = np.stack([f.to_ndarray(format="rgb24") for f in file.decode(video=0)])
    assert np.array_equal(imported("in-b")["yuv"], expected)


def test_samples_that_stand_at_the_left_are_shifted_when_asked(run: Run) -> None:
    Path("frames").mkdir()
    np.save("frames/lit.npy", DEEP << 4)
    words = ("import", "frames", *ANSWERS, "--cfa", "none")
    assert "--shift" in run(*words, "--bits", "12").complaint
    assert "the lowest 4 bits" in run(*words, "--bits", "16").complaint
    assert "uses the lowest 5 bits" in run(*words, "--bits", "12", "--shift", "5").complaint
    assert run(*words, "--bits", "12", "--shift", "4").code == 0
    assert np.array_equal(imported()["lit"], DEEP)
    assert run(*words, "--bits", "16", "--shift", "0", "--overwrite").code == 0
    assert np.array_equal(imported()["lit"], DEEP << 4)


def asked(run: Run, told: str, *words: str) -> None:
    line = run("import", "frames", *words).complaint
    assert told in line, line
    assert not Path("camtruth-out/import").exists()


def test_what_is_not_known_is_asked_for(run: Run) -> None:
    write_pngs(Path("frames/lit"), GREY)
    write_pngs(Path("frames/dark"), GREY)
    rest = ("--cfa", "none")
    everything = "--exposure dark=SECONDS --light dark=LAMP or none --exposure lit=SECONDS"
    asked(run, everything, "--camera", "x", *rest)
    asked(run, "--camera TEXT", *ANSWERS[:4], *rest)
    asked(run, "--cfa RGGB", *ANSWERS)
    asked(run, "did you mean 'dark'", *ANSWERS, *rest, "--exposure", "drak=1")
    asked(run, "expected LABEL=VALUE", *ANSWERS, *rest, "--exposure", "0.1")
    asked(run, "expected a number", *ANSWERS, *rest, "--exposure", "lit=fast")
    asked(run, "expected a number", *ANSWERS, *rest, "--light", "lit=lamp@-1")
    np.save("frames/deep.npy", DEEP)
    asked(run, "expected (20, 30) of 8", *ANSWERS, *rest)
    shutil.rmtree("frames/lit")
    shutil.rmtree("frames/dark")
    asked(run, "--bits N", *ANSWERS, *rest)
    asked(run, "at most 10 used", *ANSWERS, *rest, "--bits", "10")


def test_damage_and_foreign_things_are_one_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    asked(run, "no folder frames", *ANSWERS)
    Path("frames").mkdir()
    asked(run, "no frames in frames", *ANSWERS)
    for name in ("x.png", "x.tif", "x.fits", "x.npy", "x.mkv", "x.dng", "x.cr2"):
        for content in (b"", b"no image at all", RNG.bytes(5000)):
            (Path("frames") / name).write_bytes(content)
            asked(run, name, *ANSWERS)
        (Path("frames") / name).unlink()
    np.save("frames/x.npy", np.array([{}], dtype=object), allow_pickle=True)
    asked(run, "x.npy", *ANSWERS)
    np.save("frames/x.npy", GREY.astype(float))
    asked(run, "float64", *ANSWERS)
    np.save("frames/x.npy", COLOUR.astype(np.uint16))
    asked(run, "colour frames of 16 bits", *ANSWERS)
    np.save("frames/x.npy", GREY)
    Path("secret").mkdir()
    write_pngs(Path("secret/there"), GREY)
    Path("frames/way").symlink_to(Path("secret/there").resolve())
    asked(run, "leaves the capture folder", *ANSWERS, "--cfa", "none")
    Path("frames/way").unlink()
    monkeypatch.setenv("CAMTRUTH_MAX_PIXELS", "100")
    asked(run, "CAMTRUTH_MAX_PIXELS", *ANSWERS, "--cfa", "none")


def test_frames_of_one_shot_that_state_different_exposures(run: Run) -> None:
    write_pngs(Path("frames/lit"), COLOUR, 0.02)
    Image.fromarray(COLOUR[0]).save("frames/lit/9.png", exif=exif(0.04, "Model X"))
    asked(run, "states an exposure of 0.04 s", "--light", "*=lamp")


def test_a_manifest_says_it_outright_and_may_not_leave_the_folder(run: Run) -> None:
    write_pngs(Path("frames/a"), GREY)
    manifest = (
        'format = "camtruth-shots/1"\ncamera = "told"\npixels = "bayer8"\nbits = 8\n'
        'cfa = "BGGR"\n[[shot]]\nlabel = "dark"\nexposure_s = 0.5\nframes = "a/*.png"\n'
    )
    Path("shots.toml").write_text(manifest)
    assert run("import", "frames", "--shots", "shots.toml").code == 0
    capture = read_capture(Path("camtruth-out/import"))
    assert (capture.camera, capture.frames[0].cfa) == ("told", "BGGR")
    assert np.array_equal(capture.frames[0].dn, GREY)
    write_pngs(Path("other"), GREY)
    for frames in (
        "../other/*.png",
        "/etc/*",
        "../other/0.png",
        "/etc/passwd",
        "**x*",
        "a/**x",
        "a/none.png",
        "b/*.png",
    ):
        Path("shots.toml").write_text(manifest.replace("a/*.png", frames))
        assert run("import", "frames", "--shots", "shots.toml", "--overwrite").complaint


def chart(kind: str, run: Run) -> dict[str, tuple[float, float, float, float]]:
    """A picture of the chart in folder `frames`, and where its panels are."""
    from render.closed_form import render
    from scenes.scene import load as load_scene

    image = render(load_scene("chart").with_size(640, 480), "fluorescent")
    rate = image.rate_e_per_s
    codes = 20 + 200 * rate / np.percentile(rate, 99.5)
    codes += np.random.default_rng(1).normal(0, 2, codes.shape)
    frame = np.clip(np.rint(codes), 0, 255).astype(np.uint8)
    if kind == "bayer8":
        mosaic = np.empty((480, 640), np.uint8)
        for k, colour in enumerate("GRBG"):
            i, j = k // 2, k % 2
            mosaic[i::2, j::2] = frame[i::2, j::2, "RGB".index(colour)]
        frame = mosaic
    write_pngs(Path("frames/lit"), np.stack([frame, frame]))
    return {p.name: (p.x, p.y, p.x + p.w, p.y + p.h) for p in image.header.panels}


@pytest.mark.parametrize("kind", ["rgb8", "bayer8"])
def test_the_chart_is_found_each_panel_inside_its_patch(kind: str, run: Run) -> None:
    where = chart(kind, run)
    words = ("--cfa", "GRBG", "--panels", "chart")
    assert run("import", "frames", *ANSWERS, *words).code == 0
    panels = read_capture(Path("camtruth-out/import")).panels
    assert [panel.name for panel in panels] == [str(n) for n in range(1, 25)]
    for panel in panels:
        x0, y0, x1, y1 = where[panel.name]
        # the header's areas are clear of the blurred edges, which a patch is not: 10 px more
        assert x0 - 10 <= panel.x, panel
        assert panel.x + panel.w <= x1 + 10, panel
        assert y0 - 10 <= panel.y, panel
        assert panel.y + panel.h <= y1 + 10, panel
        assert panel.w >= 30
    with Image.open("camtruth-out/import/panels.png") as picture:
        assert np.any((np.asarray(picture) == (255, 0, 0)).all(axis=2))


def test_panels_that_are_given_and_a_chart_that_is_not_there(run: Run) -> None:
    write_pngs(Path("frames/lit"), COLOUR)
    asked(run, "no colour chart was found", *ANSWERS, "--panels", "chart")
    asked(run, "expected NAME=X,Y,W,H", *ANSWERS, "--panel", "a=1,2,3")
    asked(run, "reaches to", *ANSWERS, "--panel", "a=1,2,300,4")
    assert run("import", "frames", *ANSWERS, "--panel", "a=1,2,3,4").code == 0
    panel = read_capture(Path("camtruth-out/import")).panels[0]
    assert (panel.name, panel.x, panel.y, panel.w, panel.h) == ("a", 1, 2, 3, 4)
    assert Path("camtruth-out/import/panels.png").exists()
