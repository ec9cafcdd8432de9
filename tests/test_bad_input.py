"""Whatever is thrown at it: an answer or one line, never a traceback, a hang, a file elsewhere.

Inputs that are right are damaged in ways that people, programs and attackers damage them: bits,
cuts, inserted bytes, claims of size, numbers out of range, unknown keys, paths that lead out,
pickles. A few hundred here, the same ones every time; CAMTRUTH_CASES=5000 tries so many, anew.
"""

from __future__ import annotations

import io
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from render.rate import RateHeader, rate_image, read_rate, write_rate
from tests.damage import answer, damaged, everything_in, misspelt, refused_or_read, sandbox, share

RNG = np.random.default_rng(0)
GREY = RNG.integers(0, 200, (3, 24, 32), dtype=np.uint8)

MANIFEST = """format = "camtruth-capture/1"
camera = "mine"
pixels = "mono8"
bits = 8
scene = "chart"
[[shot]]
label = "dark"
exposure_s = 0.01
frames = "dark.npy"
[[shot]]
label = "lit"
light = ["a", "b"]
level = [0.5, 1.0]
exposure_s = 0.01
frames = "lit-*.png"
interval_s = 0.1
temperature_c = 20.0
[[panel]]
name = "19"
x = 4
y = 4
w = 10
h = 10
"""


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("capture")
    (folder / "capture.toml").write_text(MANIFEST)
    np.save(folder / "dark.npy", GREY)
    for k, frame in enumerate(GREY):
        Image.fromarray(frame).save(folder / f"lit-{k}.png")
    return folder


pytestmark = pytest.mark.filterwarnings("ignore:Exception ignored in")
"""Libraries leave damaged files open for the garbage collector."""


@share(0.2)
@given(text=misspelt(MANIFEST))
def test_manifests(text: bytes, capture: Path) -> None:
    with sandbox(capture) as folder:
        (folder / "capture.toml").write_bytes(text)
        before = everything_in(folder, folder / "none")
        answer("measure", folder, "--json")
        answer("export", folder, "--format", "npy", "--licence", "CC0-1.0", "--out", "out")
        assert everything_in(folder, folder / "none") == before


def _npy(array: Any, **options: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, **options)
    return stream.getvalue()


def _png() -> bytes:
    stream = io.BytesIO()
    Image.fromarray(GREY[0]).save(stream, format="PNG")
    return stream.getvalue()


def _tiff(folder: Path) -> bytes:
    tifffile.imwrite(folder / "x.tif", GREY, photometric="minisblack")
    return (folder / "x.tif").read_bytes()


def _fits() -> bytes:
    from astropy.io import fits

    stream = io.BytesIO()
    fits.PrimaryHDU(GREY.astype(np.uint16)).writeto(stream)
    return stream.getvalue()


def _dng(folder: Path) -> bytes:
    """A raw file as the export writes it."""
    home = folder / "dng"
    home.mkdir()
    np.save(home / "lit.npy", GREY)
    text = MANIFEST.replace('"mono8"', '"bayer8"\ncfa = "RGGB"').partition("[[shot]]")[0]
    shot = '[[shot]]\nlabel = "lit"\nexposure_s = 0.01\nframes = "lit.npy"\n'
    (home / "capture.toml").write_text(text + shot)
    out = home / "out"
    assert answer("export", home, "--format", "dng", "--licence", "CC0-1.0", "--out", out) == 0
    return (out / "frames/lit/0000000.dng").read_bytes()


def _video(folder: Path) -> bytes:
    av = pytest.importorskip("av")
    path = folder / "x.mkv"
    with av.open(str(path), "w") as file:
        stream = file.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = 32, 24, "gray"
        for frame in GREY:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="gray")))
        file.mux(stream.encode(None))
    return path.read_bytes()


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("files")
    return {
        "x.npy": _npy(GREY),
        "x.png": _png(),
        "x.tif": _tiff(folder),
        "x.fits": _fits(),
        "x.dng": _dng(folder),
        "x.mkv": _video(folder),
    }


ANSWERS = (
    "--exposure", "*=0.1", "--light", "*=a", "--camera", "c", "--cfa", "none", "--bits", "16",
    "--shift", "0",
)  # fmt: skip


@share(0.3)
@given(data=st.data())
def test_images(data: st.DataObject, files: dict[str, bytes], tmp_path_factory: Any) -> None:
    name = data.draw(st.sampled_from(sorted(files)))
    content = data.draw(damaged(files[name]))
    empty = tmp_path_factory.mktemp("empty", numbered=True)
    with sandbox(empty) as folder:
        (folder / name).write_bytes(content)
        answer("import", folder, *ANSWERS, "--out", "out")
        assert [path.name for path in folder.iterdir()] == [name]


class Payload:
    """A pickle that writes a file where it is opened."""

    def __reduce__(self) -> Any:
        return os.mkdir, ("/tmp/camtruth-was-here",)


@share(0.05)
@given(data=st.data())
def test_no_pickle_is_opened(data: st.DataObject, capture: Path) -> None:
    plain = data.draw(st.sampled_from([pickle.dumps(Payload()), pickle.dumps([Payload()], 0)]))
    stored = _npy(np.array([Payload()], dtype=object), allow_pickle=True)
    content = data.draw(st.sampled_from([plain, stored]))
    content = data.draw(damaged(content)) if data.draw(st.booleans()) else content
    with sandbox(capture) as folder:
        (folder / "dark.npy").write_bytes(content)
        assert answer("measure", folder) == 2
        answer("import", folder, *ANSWERS, "--out", "out")
    assert not Path("/tmp/camtruth-was-here").exists()


@pytest.fixture(scope="module")
def exr(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("exr") / "x.exr"
    rate = RNG.uniform(1, 1000, (16, 24, 3))
    write_rate(path, rate_image(rate, rate, RateHeader(scene="s", lamp="l")))
    return path.read_bytes()


@share(0.15)
@given(data=st.data())
def test_rate_images(data: st.DataObject, exr: bytes, tmp_path_factory: Any) -> None:
    path = tmp_path_factory.mktemp("exr", numbered=True) / "x.exr"
    path.write_bytes(data.draw(damaged(exr)))
    refused_or_read(lambda: read_rate(path))


@share(0.1)
@given(data=st.data())
def test_numpy_files(data: st.DataObject, capture: Path) -> None:
    from sensor.capture_folder import read_capture

    with sandbox(capture) as folder:
        (folder / "dark.npy").write_bytes(data.draw(damaged(_npy(GREY))))
        refused_or_read(lambda: read_capture(folder).frames[0].dn.sum())


SPEC = """format = "camtruth-dataset/1"
name = "small"
cameras = ["i400"]
bodies = 3
lamps = ["incandescent"]
levels = [0.5]
exposures_s = [0.01]
effects = [["row_noise.sigma_e=12"]]
size = [96, 72]
"""


def _documents() -> dict[str, tuple[str, Callable[[Path], object]]]:
    from camtruth.dataset.plan import plan
    from camtruth.dataset.spec import read_spec
    from sensor import camera_file, protocol

    root = Path(__file__).parents[1]
    return {
        "camera": (
            (root / "sensor/cameras/icx098.toml").read_text(),
            lambda path: camera_file.load(str(path)),
        ),
        "protocol": (
            (root / "sensor/protocols/paper.toml").read_text(),
            lambda path: protocol.load(str(path)),
        ),
        "scene": ((root / "scenes/presets/chart.toml").read_text(), _scene),
        "dataset": (SPEC, lambda path: plan(read_spec(path))),
    }


def _scene(path: Path) -> object:
    from scenes import scene

    return scene.load(str(path))


@share(0.2)
@given(data=st.data())
def test_documents(data: st.DataObject, tmp_path_factory: Any) -> None:
    documents = _documents()
    text, read = documents[data.draw(st.sampled_from(sorted(documents)))]
    path = tmp_path_factory.mktemp("doc", numbered=True) / "x.toml"
    path.write_bytes(data.draw(misspelt(text)))
    refused_or_read(lambda: read(path))


LIGHT = ("verify", "export", "import", "measure", "effects", "dataset", "capture", "doctor")
HEAVY = ("demo", "render", "roundtrip", "reproduce")
OPTIONS = (
    "--json", "--out", "--overwrite", "--resume", "--scheduler", "--format", "--licence", "--seed",
    "--camera", "--with", "--rate", "--exposure", "--light", "--cfa", "--bits", "--shift",
    "--panel", "--panels", "--shots", "--method", "--help", "--nonsense", "-x", "--",
)  # fmt: skip
VALUES = (
    "npy", "png", "out", "..", "/", "/dev/null", "", "-1", "nan", "1e999", "a=b", "*=1", "*=x",
    "a=1,2,3,4", "a=1,2,3,99999999999", "none", "RGGB", "chart", "irie", "x.py:f", "é" * 50,
    "row_noise.sigma_e=nan", "row_noise.sigma_e=1", "lamp=nothing.exr", "capture.toml", "make",
    "%s%n", "$(id)", "tcp://", "in", "in/capture.toml",
)  # fmt: skip

TYPED = st.characters(exclude_characters="\0", exclude_categories=["Cs"])
"""What a system can hand to a program: no argument holds a zero byte."""


@share(0.2)
@given(
    command=st.sampled_from((*LIGHT, *HEAVY, "", "nonsense")),
    words=st.lists(st.sampled_from((*OPTIONS, *VALUES)) | st.text(TYPED, max_size=12), max_size=6),
)
def test_command_lines(command: str, words: list[str], capture: Path) -> None:
    with sandbox(capture) as folder:
        before = everything_in(folder, folder / "none")
        heavy = ["--nonsense"] if command in (*HEAVY, "capture") else []
        answer(command, *heavy, *words)
        assert everything_in(folder, folder / "none") == before


@pytest.mark.parametrize("name", ["x.tif", "x.dng", "x.mkv", "x.png", "x.fits"])
def test_what_libraries_say_by_themselves_is_not_heard(
    name: str, files: dict[str, bytes], tmp_path: Path
) -> None:
    """Some print from C, some log: a process of its own shows all that reaches a person."""
    content = bytearray(files[name])
    content[len(content) // 2 :] = b""
    content[40:60] = bytes(20)
    (tmp_path / name).write_bytes(content)
    program = "import sys; from camtruth.command import main; sys.exit(main())"
    made = subprocess.run(
        [sys.executable, "-c", program, "import", str(tmp_path), *ANSWERS, "--out", "out"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
    )
    assert (made.returncode, made.stdout) == (2, "")
    assert re.fullmatch(r"camtruth: error: [^\n]*\n", made.stderr), made.stderr
