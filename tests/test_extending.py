"""The effect of docs/extending.md: one new file, and every command, table and law has it."""

from __future__ import annotations

import importlib.util
import inspect
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sensor.effects
from sensor.catalogue import catalogue
from tests import test_effect_laws as laws
from tests.conftest import Run, Small
from tests.test_public_face import ROOT, blocks


@pytest.fixture
def page() -> list[str]:
    return [b for b in blocks("docs/extending.md", "python") if "TapNoise" in b]


@pytest.fixture
def kind(
    page: list[str], tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Any]:
    """The page's effect, as a file in a folder that the package `sensor.effects` spans."""
    folder = tmp_path_factory.mktemp("effects")
    (folder / "tap_noise.py").write_text(page[0], encoding="utf-8")
    monkeypatch.setattr(sensor.effects, "__path__", [*sensor.effects.__path__, str(folder)])
    catalogue.cache_clear()
    yield catalogue()["tap_noise"]
    sys.modules.pop("sensor.effects.tap_noise")
    monkeypatch.undo()
    catalogue.cache_clear()


def test_the_commands_know_it(kind: Any, run: Run, small: Small, tmp_path: Path) -> None:
    assert "tap_noise" in run("effects").out
    told = run("effects", "tap_noise").out
    for word in ("sigma n(k, half of x)", "0", "1000", "e-", kind.reference):
        assert word in told
    words = ("capture", small.protocol, *small.words, "--out", "made")
    assert run(*words, "--with", "tap_noise.sigma_e=300").code == 0
    truth = json.loads((tmp_path / "made" / "truth.json").read_text(encoding="utf-8"))
    found = {effect["name"]: effect["parameters"] for effect in truth["effects"]}
    assert found["tap_noise"] == {"sigma_e": {"value": 300.0, "unit": "e-"}}
    frames = np.load(tmp_path / "made" / "full.npy").astype(float)
    halves = np.split(frames.mean(3), 2, axis=2)
    # 300 e- are 4.5 DN; without the effect the means of halves differ by some 0.01 DN
    assert (halves[0].mean((1, 2)) - halves[1].mean((1, 2))).std() > 0.5
    refusal = run(*words, "--overwrite", "--with", "tap_noise.sigma_e=2000").complaint
    assert "expected 0 to 1000 e-" in refusal


def test_the_table_of_the_documents_has_it(kind: Any) -> None:
    spec = importlib.util.spec_from_file_location("make_docs", ROOT / "docs" / "make.py")
    assert spec
    assert spec.loader
    make = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make)
    assert f"| `{kind.name}` | readout | `sigma_e` | e- | 20 | 0 | 1000 |" in make.catalogue_page()


def test_every_law_holds_for_it(kind: Any) -> None:
    """All laws that are run for each effect of the catalogue, on each backend."""
    run_laws = 0
    for name, law in vars(laws).items():
        takes = inspect.signature(law).parameters if name.startswith("test_") else {}
        if "kind" in takes:
            for where in laws.BACKENDS if "where" in takes else (None,):
                law(kind, where) if where else law(kind)
                run_laws += 1
    assert run_laws >= 8


def test_its_own_test_passes_and_an_impostor_fails_it(
    kind: Any, page: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Independent noise of the same variance in every pixel is no tap noise."""
    names: dict[str, Any] = {}
    exec(page[1], names)
    names["test_the_halves_move_against_each_other"]()

    def independent(self: Any, signal: Any, stream: Any) -> Any:
        noise = stream.normal(*signal.shape[1:])
        return signal.replace(signal.value + self.sigma_e * noise)

    monkeypatch.setattr(kind, "apply", independent)
    with pytest.raises(AssertionError, match="variance between the halves"):
        names["test_the_halves_move_against_each_other"]()
