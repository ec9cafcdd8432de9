"""The chain from lamp to electrons, by hand: as docs/light.md has it, in plain arithmetic."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from render import closed_form, path_traced
from scenes.lamp import Lamp
from scenes.scene import Scene, load
from tests.harness import z_limit

PAGE = Path(__file__).parents[1] / "docs" / "light.md"


def _even(folder: Path) -> Scene:
    """An even card, a lamp and a camera without colour, and no barrel."""
    nm = range(400, 701, 5)
    (folder / "flat.csv").write_text("nm,value\n" + "".join(f"{x},1\n" for x in nm))
    (folder / "eye.csv").write_text("nm,R,G,B\n" + "".join(f"{x},1,1,1\n" for x in nm))
    scene = load("uniform")
    lamp = Lamp(
        name="lamp",
        spd=str(folder / "flat.csv"),
        position_m=(0.0, 0.40, 0.45),
        intensity_w_per_sr=1.0,
    )
    return dataclasses.replace(
        scene,
        lamp=(lamp,),
        lens=dataclasses.replace(scene.lens, barrel=None),
        detector=dataclasses.replace(scene.detector, response=str(folder / "eye.csv")),
    )


def _by_hand() -> float:
    """W/sr to e-/s for the middle of the image; no code of ours."""
    irradiance = 1.0 * (0.45 / math.sqrt(0.3625)) / 0.3625
    radiance = 0.9 * irradiance / 3.14159265
    image_m = 1 / (1 / 0.0043 - 1 / 0.18)
    solid_angle = 3.14159265 * 0.001075**2 / image_m**2
    power = radiance * 0.9 * solid_angle * 5.6e-6 * 5.6e-6
    photon = 6.62607015e-34 * 299792458 / 550e-9
    return 0.4 * power / photon


def test_the_formula_gives_what_the_hand_does(tmp_path: Path) -> None:
    rate = closed_form.render(_even(tmp_path), "lamp").rate_e_per_s[239:241, 319:321]
    # The four middle pixels lie half a pixel off the axis; their mean is that of the axis.
    assert rate.mean(axis=(0, 1)) == pytest.approx(np.full(3, _by_hand()), rel=1e-5)
    assert rate[0, 0] == pytest.approx(np.full(3, _by_hand()), rel=2e-3)


def test_the_traced_light_does_too(tmp_path: Path) -> None:
    """The mean of the middle 4 x 4 pixels of a small image, within its error."""
    scene = _even(tmp_path).with_size(160, 120)
    image = path_traced.render(scene, "lamp")
    middle = slice(58, 62), slice(78, 82)
    rate = image.rate_e_per_s[middle].mean(axis=(0, 1), dtype=float)
    expected = _by_hand() * 16  # pixels four times as wide
    error = np.sqrt(image.variance[middle].mean(axis=(0, 1), dtype=float) / 16)
    # Over 4 pixels cos^4 curves by 1.4e-4, the light by as much.
    assert (abs(rate - expected) < z_limit(3) * error + 3e-4 * expected).all()


def test_the_page_has_the_same_figure() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert f"| {_by_hand():.5g} | e⁻/s |" in text
    for name in ("noise", "lamps", "lenses", "surfaces", "response", "hand"):
        assert f"<!-- {name} -->" not in text
