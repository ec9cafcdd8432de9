"""The camera behind the printed figures: read in closed form, and the riddle."""

from __future__ import annotations

import pytest

from analysis.debias.riddle import ANSWERS, ratios
from analysis.debias.search import ERRORS, IN_TIME, KEYS, MODEL, reads, search
from analysis.reproduce.paper import printed
from sensor.camera_file import load
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.fpn import Fpn
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise


def preset(channel: str) -> dict[str, float]:
    """The figures of the preset that the search is about, in DN."""
    camera = load("i400-debiased")
    gain = camera.gain_dn_per_e[channel]
    read, fpn, prnu, clamp = map(camera.get, (ReadNoise, Fpn, Prnu, BlackLevelOffset))
    return {
        "read": gain * read.sigma_e[channel],
        "fpn": max(gain * fpn.sigma_e[channel], 1e-3),
        "gain": gain,
        "prnu": prnu.ratio[channel],
        "black": camera.black_dn + gain * clamp.offset_e[channel],
    }


@pytest.mark.parametrize("channel", ["R", "G", "B"])
def test_the_preset_is_read_as_the_printed_noise_in_time(channel):
    """Within the errors of one capture: the preset's figures are rounded to far less."""
    found = reads(channel, preset(channel), "text")
    for key in IN_TIME:
        error = max(ERRORS[key], MODEL * abs(printed()[key].value[channel]))
        assert abs(found[key] - printed()[key].value[channel]) < error, key


def test_a_known_camera_is_found_from_its_figures():
    """Figures made in closed form, so that nothing but the search can miss it."""
    true = {"read": 2.0, "fpn": 0.6, "gain": 0.1, "prnu": 0.012, "black": 1.0}
    found = search("B", reads("B", true, "text"), "text")
    for name, value in true.items():
        assert found.values[name] == pytest.approx(value, rel=0.03, abs=0.03), name
    assert found.chi2 < 0.1
    assert set(found.misfit) == set(KEYS)


def test_no_camera_of_equation_1_has_greens_printed_fpn():
    """Without any FPN the technique still reads nearly twice the print, in either order."""
    values = preset("G") | {"fpn": 1e-3}
    for order in ("text", "printed"):
        assert reads("G", values, order)["fpn"] > 1.8 * printed()["fpn"].value["G"]


@pytest.mark.parametrize(
    ("name", "red", "blue"),
    [
        ("nothing", 1.0, 1.0),
        ("white balance, red 2.6 and blue 2.0", 2.6, 2.0),
    ],
)
def test_a_gain_shows_in_read_squared_over_k_squared(name, red, blue):
    """Rounding adds 1/12 to read noise of 1.5 DN before gains and not after: 4 % at most."""
    found = ratios(ANSWERS[name])
    for channel, gain in (("R", red), ("B", blue)):
        assert found[channel]["ratio"] / found["G"]["ratio"] == pytest.approx(gain, rel=0.06)


def test_mixing_colours_does_not():
    """Print, debiased, asks for 11 in red and 6 in blue."""
    found = ratios(ANSWERS["YUV 4:2:2 in 8 bits"])
    for channel in "RB":
        assert 0.6 < found[channel]["ratio"] / found["G"]["ratio"] < 1.6
