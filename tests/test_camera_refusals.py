"""Settings and camera files that cannot be: one line with the way out, and nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import Run, Small

SETTINGS = {
    "no number": ("row_noise.sigma_e=loud", "EFFECT.PARAMETER=NUMBER"),
    "nothing": ("row_noise.sigma_e=", "EFFECT.PARAMETER=NUMBER"),
    "no parameter": ("row_noise=12", "EFFECT.PARAMETER=NUMBER"),
    "no effect": (".sigma_e=12", "EFFECT.PARAMETER=NUMBER"),
    "not a number": ("row_noise.sigma_e=nan", "expected 0 to 1000 e-"),
    "infinite": ("row_noise.sigma_e=inf", "expected 0 to 1000 e-"),
    "below its range": ("gamma.exponent=0.1", "expected 0.3 to 3"),
    "above its range in DN": ("row_noise.sigma_dn=500", "expected 0 to 1000 e-"),
    "a fraction of a choice": ("jpeg.quality=90.5", "whole number from 1 to 100"),
    "an effect misspelt": ("row_nois.sigma_e=1", "did you mean 'row_noise'?"),
    "another's parameter": ("row_noise.amplitude_e=1", "camtruth effects row_noise"),
    "one that has none": ("photon_shot.bits=3", "expected none"),
}


@pytest.mark.parametrize("case", SETTINGS)
def test_refused_setting(case: str, run: Run, small: Small, tmp_path: Path) -> None:
    setting, remedy = SETTINGS[case]
    words = ("capture", small.protocol, *small.words, "--with", setting, "--out", "made")
    assert remedy in run(*words).complaint
    assert list(tmp_path.iterdir()) == []


CAMERAS = {
    "another format": ('camera/1"', 'camera/9"', "camtruth-camera/1"),
    "unknown key": ("black_dn = 3.0", "black = 3.0", "black_dn"),
    "missing gain": ("gain_dn_per_e = 0.01515", "", "gain_dn_per_e"),
    "no gain": ("gain_dn_per_e = 0.01515", "gain_dn_per_e = 0.0", "positive"),
    "a gain for two colours": ("= 0.01515", "= {R = 0.02, G = 0.01}", "gain_dn_per_e"),
    "words for a number": ("ratio = 0.01", 'ratio = "much"', "ratio"),
    "not a number": ("ratio = 0.01", "ratio = nan", "finite number"),
    "out of range": ("ratio = 0.01", "ratio = 0.5", "expected 0 to 0.2"),
    "unknown parameter": ("ratio = 0.01", "sigma = 0.01", "camtruth effects prnu"),
    "unknown effect": ("[effects.fpn]", "[effects.fpm]", "did you mean 'fpn'?"),
    "an effect twice": ("[effects.read_noise]", "[effects.fpn]", "camera.toml"),
    "out of order": (
        "[effects.prnu]\nratio = 0.01\n[effects.photon_shot]",
        "[effects.photon_shot]\n[effects.prnu]\nratio = 0.01",
        "'prnu' comes first",
    ),
    "colours per parameter that has none": (
        "[effects.demosaic]",
        "[effects.row_noise]\nsigma_e = {R = 1.0, G = 2.0, B = 1.0}\n[effects.demosaic]",
        "one figure",
    ),
    "no such pixels": ("black_dn = 3.0", 'black_dn = 3.0\npixels = "rgb9"', "rgb8"),
    "too many bits": ("black_dn = 3.0", "black_dn = 3.0\nbits = 12", "expected them to fit"),
    "no such mosaic": ("black_dn = 3.0", 'black_dn = 3.0\ncfa = "CMYK"', "RGGB"),
    "a mosaic of one colour": ("black_dn = 3.0", 'black_dn = 3.0\ncfa = "RRRR"', "one R, one B"),
    "greens side by side": ("black_dn = 3.0", 'black_dn = 3.0\ncfa = "RBGG"', "G twice on a diag"),
    "no green on a mosaic": (
        "black_dn = 3.0",
        'black_dn = 3.0\npixels = "bayer8"\ncfa = "GGGG"',
        "which is no mosaic",
    ),
    "a gain that is no number": ("= 0.01515", "= nan", "expected a finite number"),
    "an infinite gain": ("= 0.01515", "= {R = inf, G = 0.01, B = 0.01}", "expected a finite"),
    "a sensitivity that is no number": (
        "black_dn = 3.0",
        "black_dn = 3.0\nsensitivity = nan",
        "expected a finite number",
    ),
    "no black": ("black_dn = 3.0", "black_dn = nan", "expected a finite number"),
    "a gain that is true": ("= 0.01515", "= true", "expected a number"),
    "width in quotes": ("width = 160", 'width = "160"', "expected a whole number"),
    "no width": ("width = 160", "width = 0", "width"),
    "half a pixel": ("width = 160", "width = 160.5", "width"),
    "colours without a demosaicer": ("[effects.demosaic]\n", "", "add or remove"),
    "no document": ("format", "= format", "camera.toml"),
}


@pytest.mark.parametrize("case", CAMERAS)
def test_refused_camera_file(case: str, run: Run, small: Small, tmp_path: Path) -> None:
    old, new, remedy = CAMERAS[case]
    text = small.camera.read_text(encoding="utf-8")
    assert old in text
    file = tmp_path / "camera.toml"
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    rate = f"incandescent={small.rate}"
    words = ("capture", small.protocol, "--camera", file, "--rate", rate, "--out", "made")
    assert remedy in run(*words).complaint
    assert list(tmp_path.iterdir()) == [file]


def test_a_codec_of_eight_bits_on_a_mosaic(run: Run, small: Small, tmp_path: Path) -> None:
    text = small.camera.read_text(encoding="utf-8").replace("[effects.demosaic]\n", "")
    file = tmp_path / "camera.toml"
    file.write_text(text.replace("black_dn", 'pixels = "bayer8"\nblack_dn'), encoding="utf-8")
    rate = f"incandescent={small.rate}"
    words = ("capture", small.protocol, "--camera", file, "--rate", rate, "--out", "made")
    assert "'jpeg' on a mosaic" in run(*words, "--with", "jpeg.quality=90").complaint
    assert list(tmp_path.iterdir()) == [file]
