"""The catalogue page is written by the code, and every effect has its figure."""

from __future__ import annotations

import inspect
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from docs.effects_page import catalogue_page
from sensor.catalogue import catalogue
from tests.conftest import Run
from tests.test_public_face import ROOT

FIGURES = ROOT / "docs" / "figures" / "effects"


def test_the_page_is_what_the_code_writes() -> None:
    text = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")
    assert text == catalogue_page(), "docs/effects.md is not of this code; run 'make docs'"


def test_every_effect_has_its_figure_and_none_is_left_over() -> None:
    assert {path.stem for path in FIGURES.glob("*")} == set(catalogue())


@pytest.mark.parametrize("name", catalogue())
def test_a_figure_shows_four_pictures(name: str) -> None:
    with Image.open(FIGURES / f"{name}.png") as image:
        grey = np.asarray(image.convert("L"), float)
    assert grey.shape[1] > 3 * grey.shape[0]
    # the two frames, their difference and the curves each have something to see
    for part in np.array_split(grey[grey.shape[0] // 4 :], 4, axis=1):
        assert part.std() > 5


@pytest.mark.parametrize("name", catalogue())
def test_the_command_tells_all_that_an_effect_states(name: str, run: Run) -> None:
    kind = catalogue()[name]
    told = run("effects", name).out
    assert inspect.cleandoc(kind.__doc__ or "") in told
    assert kind.reference in told
    assert kind.stage.value in told
    for p in kind.parameters():
        for word in (p.name, p.unit, p.doc, *(f"{x:g}" for x in (p.default, p.minimum, p.maximum))):
            assert word in told
    assert not kind.parameters() or f"--with {name}." in told


def test_figures_are_kept_small() -> None:
    sizes = [path.stat().st_size for path in Path(FIGURES).glob("*.png")]
    assert max(sizes) < 60_000
