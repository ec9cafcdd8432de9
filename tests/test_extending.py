"""What docs/extending.md adds is one new file.

An effect, which every command, table and law has; and a format, which `camtruth import` takes.
"""

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

import camtruth.exchange.readers
import sensor.effects
from camtruth.exchange.reader import readers
from camtruth.exchange.readers import images
from sensor import stack_files
from sensor.capture_folder import read_capture
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


@pytest.fixture
def pgm(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The page's reader, as a file in a folder that the package of readers spans."""
    (page,) = [b for b in blocks("docs/extending.md", "python") if "READER" in b]
    folder = tmp_path_factory.mktemp("readers")
    (folder / "pgm.py").write_text(page, encoding="utf-8")
    package = camtruth.exchange.readers
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
    readers.cache_clear()
    yield
    sys.modules.pop("camtruth.exchange.readers.pgm", None)
    monkeypatch.undo()
    readers.cache_clear()


WORDS = ("import", "frames", "--exposure", "*=0.02", "--light", "*=lamp", "--cfa", "none",
         "--camera", "mine")  # fmt: skip


def write_pgm(stack: np.ndarray[Any, Any], largest: int) -> None:
    (Path("frames") / "lit").mkdir(parents=True)
    for k, frame in enumerate(stack):
        header = b"P5\n%d %d\n%d\n" % (frame.shape[1], frame.shape[0], largest)
        (Path("frames/lit") / f"{k}.pgm").write_bytes(header + frame.tobytes())


@pytest.mark.parametrize(("kind", "largest"), [("u1", 255), (">u2", 4095)])
def test_frames_of_a_new_format_come_in(pgm: Any, run: Run, kind: str, largest: int) -> None:
    stack = np.random.default_rng(1).integers(0, largest + 1, (3, 6, 8)).astype(kind)
    write_pgm(stack, largest)
    assert run(*WORDS).code == 0
    (frames,) = read_capture(Path("camtruth-out/import")).frames
    assert np.array_equal(frames.dn, stack)
    assert frames.bits == largest.bit_length()
    record = json.loads(Path("camtruth-out/import/import.json").read_text(encoding="utf-8"))
    assert record["shots"][0]["header"] == {"where": "PGM header", "bits": largest.bit_length()}


def test_damage_to_it_is_one_line_and_help_names_it(pgm: Any, run: Run) -> None:
    write_pgm(np.zeros((1, 6, 8), np.uint8), 255)
    whole = Path("frames/lit/0.pgm").read_bytes()
    for damaged in (b"", b"P5", b"P5 0 0 255 ", whole[:-1], whole.replace(b"255", b"99999")):
        Path("frames/lit/0.pgm").write_bytes(damaged)
        assert "is no whole PGM" in run(*WORDS).complaint
    Path("frames/lit/0.pgm").write_bytes(b"P5 99999 99999 255 ")
    assert "CAMTRUTH_MAX_PIXELS" in run(*WORDS).complaint
    Path("frames/lit/0.pgm").unlink()
    assert ".pef, .pgm, .png" in run(*WORDS).complaint


def test_without_its_file_it_is_left_aside(run: Run) -> None:
    write_pgm(np.zeros((1, 6, 8), np.uint8), 255)
    assert "no frames in frames" in run(*WORDS).complaint


def test_no_two_readers_claim_an_ending() -> None:
    claimed = [name for reader in readers() for name in (*reader.endings, *reader.marks)]
    assert len(claimed) == len(set(claimed)) >= 20


def test_import_reads_every_image_that_a_capture_folder_may_hold() -> None:
    """From the table of the capture folder: a new function there is enough."""
    assert images.READER.endings == (".npy", *stack_files._READERS)
    assert set(images.HEADERS) <= set(stack_files._READERS)
