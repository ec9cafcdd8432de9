"""The rate image on disk: what is written is read, and nothing else is."""

from __future__ import annotations

import dataclasses
import json
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foundation.errors import OutputError
from foundation.panel import Panel
from render import preview
from render.errors import RenderError
from render.rate import RateHeader, RateImage, rate_image, read_rate, write_rate

HEADER = RateHeader(
    scene="chart",
    lamp="fluorescent",
    optics={"f_number": 2.0, "kind": "thin"},
    samples=72,
    seed=3,
    versions={"numpy": "2"},
    panels=(Panel(name="19", x=1, y=2, w=3, h=4),),
    noise={"R": 1e-4},
)


def _image(height: int = 7, width: int = 5) -> RateImage:
    rng = np.random.default_rng(0)
    rate = rng.uniform(1, 1e5, (height, width, 3))
    return rate_image(rate, rate * 1e-3, HEADER)


def _write_raw(path: Path, channels: dict[str, Any], **header: Any) -> Path:
    complete = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "camtruth": json.dumps(dataclasses.asdict(HEADER)),
        **header,
    }
    OpenEXR.File({k: v for k, v in complete.items() if v is not None}, channels).write(str(path))
    return path


def _planes(**changes: Any) -> dict[str, Any]:
    names = ("R", "G", "B", "R.var", "G.var", "B.var")
    planes: dict[str, Any] = {name: np.ones((7, 5), np.float32) for name in names}
    planes.update(changes)
    return {name: plane for name, plane in planes.items() if plane is not None}


def test_a_rate_image_survives_the_disk_bit_by_bit(tmp_path: Path) -> None:
    image = _image()
    write_rate(tmp_path / "rate.exr", image)
    again = read_rate(tmp_path / "rate.exr")
    np.testing.assert_array_equal(again.rate_e_per_s, image.rate_e_per_s)
    np.testing.assert_array_equal(again.variance, image.variance)
    assert again.header == image.header
    assert not again.rate_e_per_s.flags.writeable
    assert not again.variance.flags.writeable


def test_the_file_is_the_contracts(tmp_path: Path) -> None:
    write_rate(tmp_path / "rate.exr", _image())
    with OpenEXR.File(str(tmp_path / "rate.exr"), separate_channels=True) as file:
        assert sorted(file.channels()) == ["B", "B.var", "G", "G.var", "R", "R.var"]
        assert all(c.pixels.dtype == np.float32 for c in file.channels().values())
        header = json.loads(file.header()["camtruth"])
    assert {"scene", "lamp", "optics", "samples", "seed", "versions", "panels"} <= set(header)
    assert header["panels"] == [{"name": "19", "x": 1, "y": 2, "w": 3, "h": 4}]


@pytest.mark.parametrize("part", [0.0, 0.02, 0.3, 0.6, 0.95, 0.999])
def test_a_truncated_file_is_refused(tmp_path: Path, part: float) -> None:
    path = tmp_path / "rate.exr"
    write_rate(path, _image(200, 100))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(RenderError) as caught:
        read_rate(path)
    assert "\n" not in str(caught.value)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(position=st.floats(0, 1), byte=st.integers(0, 255))
def test_a_damaged_file_is_read_or_refused_but_never_worse(
    tmp_path_factory: pytest.TempPathFactory, position: float, byte: int
) -> None:
    path = tmp_path_factory.mktemp("damaged") / "rate.exr"
    write_rate(path, _image())
    content = bytearray(path.read_bytes())
    content[int(position * (len(content) - 1))] = byte
    path.write_bytes(bytes(content))
    told = ""
    try:
        rate = read_rate(path).rate_e_per_s
    except RenderError as problem:
        told = str(problem)
    else:
        assert np.isfinite(rate).all()
        assert (rate >= 0).all()
    assert "\n" not in told


@pytest.mark.parametrize(
    ("changes", "header", "message"),
    [
        ({"G": None}, {}, "no channel 'G'"),
        ({"B.var": None}, {}, "no channel 'B.var'"),
        ({"R": np.ones((7, 5), np.float16)}, {}, "'R' in .* is not float32"),
        ({"R": np.full((7, 5), np.nan, np.float32)}, {}, "NaN or infinity"),
        ({"G.var": np.full((7, 5), np.inf, np.float32)}, {}, "NaN or infinity"),
        ({"B": np.full((7, 5), -1, np.float32)}, {}, "as low as -1"),
        ({}, {"camtruth": None}, "no header attribute"),
        ({}, {"camtruth": "{"}, "is not JSON"),
        ({}, {"camtruth": '{"scene": "chart"}'}, "no key 'lamp'"),
        ({}, {"camtruth": '{"scene": "a", "lamp": "b", "gain": 1}'}, "unknown key 'gain'"),
        (
            {},
            {
                "camtruth": '{"scene": "a", "lamp": "b", "panels":'
                ' [{"name": "1", "x": 4, "y": 0, "w": 9, "h": 1}]}'
            },
            "panel '1' in .* ends at column 13",
        ),
    ],
)
def test_a_lying_file_is_refused(
    tmp_path: Path, changes: dict[str, Any], header: dict[str, Any], message: str
) -> None:
    path = _write_raw(tmp_path / "rate.exr", _planes(**changes), **header)
    with pytest.raises(RenderError, match=message) as caught:
        read_rate(path)
    assert "\n" not in str(caught.value)


def test_an_absurd_size_is_refused_before_it_is_made(tmp_path: Path) -> None:
    path = tmp_path / "rate.exr"
    write_rate(path, _image())
    content = path.read_bytes()
    start = content.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    huge = np.array([0, 0, 99_999_999, 99_999_999], "<i4").tobytes()
    path.write_bytes(content[:start] + huge + content[start + 16 :])
    with pytest.raises(RenderError):
        read_rate(path)


def test_what_is_no_rate_image_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.exr").write_text("hello")
    for path in (tmp_path / "absent.exr", tmp_path, tmp_path / "text.exr"):
        with pytest.raises(RenderError):
            read_rate(path)
    with pytest.raises(RenderError, match=r"expected \(H, W, 3\)"):
        rate_image(np.ones((4, 4)), np.ones((4, 4)), HEADER)
    with pytest.raises(RenderError, match="expected equal shapes"):
        rate_image(np.ones((9, 9, 3)), np.ones((9, 8, 3)), HEADER)


def test_a_failed_write_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        write_rate(tmp_path / "file" / "rate.exr", _image())
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_the_preview_shows_the_white_panel_neutral() -> None:
    rate = np.broadcast_to([100.0, 200.0, 50.0], (8, 8, 3)).copy()
    rate[:, 6:] *= 0.2
    picture = preview.balanced(rate_image(rate, rate * 0, HEADER))
    assert picture.dtype == np.uint8
    # sRGB of 0.9 and of 0.18, IEC 61966-2-1
    assert (picture[:, :6] == round(255 * (1.055 * 0.9 ** (1 / 2.4) - 0.055))).all()
    assert (picture[:, 6:] == round(255 * (1.055 * 0.18 ** (1 / 2.4) - 0.055))).all()


def test_readers_in_many_threads_leave_standard_output_alone(tmp_path: Path) -> None:
    """What is printed after them is seen."""
    path = tmp_path / "rate.exr"
    write_rate(path, _image())
    before = sys.stdout
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda _: read_rate(path), range(400)))
    assert sys.stdout is before
