"""What the command tests share: a way to run a command line, and a small camera with its light."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

WIDTH, HEIGHT = 160, 120

PROTOCOL = """
name = "small"
[[shot]]
label = "dark"
exposure_s = 0.03268
frames = 6
[[shot]]
label = "half"
light = "incandescent"
level = 0.5
exposure_s = 0.03268
frames = 6
[[shot]]
label = "full"
light = "incandescent"
exposure_s = 0.03268
frames = 6
"""

CAMERA = f"""
format = "camtruth-camera/1"
name = "small"
width = {WIDTH}
height = {HEIGHT}
gain_dn_per_e = 0.01515
black_dn = 3.0
[effects.prnu]
ratio = 0.01
[effects.photon_shot]
[effects.fpn]
sigma_e = 10.0
[effects.read_noise]
[effects.demosaic]
[effects.quantization]
"""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a command left behind: exit code, standard output, standard error."""

    code: int
    out: str
    err: str

    @property
    def complaint(self) -> str:
        """The one line of a refused command; fails unless it is exactly that."""
        assert self.code == 2, self
        assert self.out == "", self
        assert self.err.startswith("camtruth: error: "), self
        assert self.err.count("\n") == 1, self
        assert self.err.endswith("\n"), self
        assert self.err.count("; ") >= 2, self
        return self.err


Run = Callable[..., Answer]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run a command line in an empty folder."""
    from camtruth.command import main

    monkeypatch.chdir(tmp_path)

    def go(*words: object) -> Answer:
        capsys.readouterr()
        code = main([str(word) for word in words])
        printed = capsys.readouterr()
        return Answer(code=code, out=printed.out, err=printed.err)

    return go


@dataclass(frozen=True, kw_only=True)
class Small:
    """Files of a camera of 160 x 120 pixels, three shots and the light on its sensor."""

    camera: Path
    protocol: Path
    rate: Path

    @property
    def words(self) -> tuple[str, ...]:
        """The part of a command line that names them."""
        return "--camera", str(self.camera), "--rate", f"incandescent={self.rate}"


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Small:
    """A small camera, its light by the closed form: nothing is path-traced."""
    from render.closed_form import render
    from render.rate import write_rate
    from scenes.scene import load

    folder = tmp_path_factory.mktemp("small")
    (folder / "camera.toml").write_text(CAMERA, encoding="utf-8")
    (folder / "protocol.toml").write_text(PROTOCOL, encoding="utf-8")
    write_rate(folder / "rate.exr", render(load("chart").with_size(WIDTH, HEIGHT), "incandescent"))
    return Small(
        camera=folder / "camera.toml",
        protocol=folder / "protocol.toml",
        rate=folder / "rate.exr",
    )


@pytest.fixture(scope="session")
def small_capture(small: Small, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A capture folder made by the command."""
    from camtruth.command import main

    folder = tmp_path_factory.mktemp("capture") / "made"
    words = ["capture", str(small.protocol), *small.words, "--seed", "3", "--out", str(folder)]
    assert main(words) == 0
    return folder
