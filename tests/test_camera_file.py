"""Camera files: presets, units, and settings from the command line."""

from __future__ import annotations

import dataclasses
import tomllib
from importlib import resources
from pathlib import Path
from typing import ClassVar

import pytest

from foundation.errors import InputError
from sensor.camera_file import load, preset_names, with_setting, write
from sensor.colours import Colours
from sensor.effects.fpn import Fpn
from sensor.effects.read_noise import ReadNoise
from sensor.effects.row_noise import RowNoise
from sensor.errors import CameraError


@pytest.mark.parametrize("name", preset_names())
def test_a_camera_written_is_the_camera_read(name: str, tmp_path: Path) -> None:
    write(tmp_path / "camera.toml", load(name))
    assert load(str(tmp_path / "camera.toml")) == load(name)


@pytest.mark.parametrize("name", preset_names())
def test_every_figure_of_a_preset_names_its_source(name: str) -> None:
    """A comment on the line of the figure, or in the block right above it."""
    text = (resources.files("sensor") / "cameras" / f"{name}.toml").read_text()
    tomllib.loads(text)
    said = False
    for line in text.splitlines():
        if not line.strip():
            said = False
        said = said or "#" in line
        if "=" in line.split("#")[0] and not line.startswith(("format", "name")):
            assert said, line


def test_a_file_with_an_effect_of_the_users_own_is_read_where_it_is_given(tmp_path: Path) -> None:
    """As `camtruth diagnose` writes it where it names one."""

    @dataclasses.dataclass(frozen=True, kw_only=True)
    class Stripes(RowNoise):
        name: ClassVar[str] = "stripes"

    camera = load("ideal").plus(Stripes(sigma_e=7.0))
    write(tmp_path / "camera.toml", camera)
    with pytest.raises(CameraError, match="unknown effect 'stripes'"):
        load(str(tmp_path / "camera.toml"))
    assert load(str(tmp_path / "camera.toml"), {"stripes": Stripes}) == camera


def test_figures_in_dn_are_divided_by_the_gain_of_their_colour() -> None:
    camera = load("i400")
    read, fpn = camera.get(ReadNoise), camera.get(Fpn)
    assert read is not None
    assert fpn is not None
    for channel, dn in {"R": 1.612, "G": 0.613, "B": 1.240}.items():
        assert read.sigma_e[channel] * camera.gain_dn_per_e[channel] == pytest.approx(dn)
    assert Colours.of(fpn.sigma_e)["B"] * camera.gain_dn_per_e["B"] == pytest.approx(0.247)


def test_a_setting_changes_an_effect_or_adds_it() -> None:
    camera = load("icx098")
    changed = with_setting(camera, "fpn.sigma_e=33")
    assert changed.get(Fpn) == Fpn(sigma_e=33.0)
    assert with_setting(camera.without(Fpn), "fpn.sigma_e=33") == changed
    in_dn = with_setting(camera, "fpn.sigma_dn=0.5").get(Fpn)
    assert in_dn is not None
    assert pytest.approx(0.5 / 0.01515) == Colours.of(in_dn.sigma_e).G


BAD_SETTINGS = {
    "fnp.sigma_e=3": "did you mean 'fpn'",
    "fpn.sigma=3": "has no parameter 'sigma'",
    "fpn.sigma_e=-3": "expected 0 to 1000 e-",
    "fpn.sigma_e=many": "EFFECT.PARAMETER=NUMBER",
    "fpn.sigma_e=nan": "expected 0 to",
    "fpn": "EFFECT.PARAMETER=NUMBER",
    "": "EFFECT.PARAMETER=NUMBER",
}


@pytest.mark.parametrize("setting", BAD_SETTINGS)
def test_a_bad_setting_is_told_in_one_line(setting: str) -> None:
    with pytest.raises(InputError, match=BAD_SETTINGS[setting]):
        with_setting(load("i400"), setting)


BAD_CAMERAS = {
    "unknown key": ("bits = 8", "bitz = 8", "unknown key 'bitz'"),
    "unknown effect": ("[effects.fpn]", "[effects.fnp]", "did you mean 'fpn'"),
    "unknown parameter": ("ratio =", "ration =", "no parameter 'ration'"),
    "out of range": ("ratio = {", "ratio = 7 # {", "expected 0 to 0.2"),
    "wrong order": ("[effects.prnu]", "[effects.quantization]\n[effects.prnu]", "quantization"),
    "zero gain": ("R = 0.044944", "R = 0.0", "gain"),
    "colours of no filter": ('"RGGB"', '"RGBX"', "cfa"),
    "a missing colour": ("R = 0.0104, ", "", "ratio"),
}


@pytest.mark.parametrize("case", BAD_CAMERAS)
def test_a_camera_that_cannot_be_is_refused(case: str, tmp_path: Path) -> None:
    old, new, told = BAD_CAMERAS[case]
    text = (resources.files("sensor") / "cameras" / "i400.toml").read_text()
    assert old in text
    path = tmp_path / "bad.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load(str(path))
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_camera_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="did you mean 'i400'"):
        load("i40")
    with pytest.raises(InputError, match=r"nowhere\.toml"):
        load("nowhere.toml")
