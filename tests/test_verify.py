"""A folder is whole, or the first file that is amiss is named: exit code 2 and one line."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from foundation.errors import InputError
from foundation.output import CHECKSUMS, new_folder
from foundation.verification import read_checksums, verify
from tests.conftest import Run


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    with new_folder(tmp_path / "made") as scratch:
        (scratch / "deep").mkdir()
        (scratch / "deep/a.bin").write_bytes(np.random.default_rng(1).bytes(1000))
        (scratch / "deep" / CHECKSUMS).write_text("a list of its own is a file like others\n")
        (scratch / "b with blanks.txt").write_text("b")
    return tmp_path / "made"


def test_a_whole_folder(folder: Path, run: Run) -> None:
    told = []
    whole = verify(folder, told.append)
    assert (whole.files, whole.size_bytes, sum(told)) == (3, 1041, 3)
    assert "whole, 3 files of 1041 bytes" in run("verify", folder).out
    answer = json.loads(run("verify", folder, "--json").out)
    assert answer == {
        "format": "camtruth-verify/1",
        "verdict": "whole",
        "files": 3,
        "bytes": 1041,
    }


def flip(path: Path, bit: int) -> None:
    content = bytearray(path.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def test_any_flipped_bit_is_found(folder: Path) -> None:
    path = folder / "deep/a.bin"
    for bit in (0, 7999, *np.random.default_rng(2).integers(0, 8000, 30)):
        flip(path, int(bit))
        with pytest.raises(InputError, match=r"a\.bin has sha256"):
            verify(folder)
        flip(path, int(bit))
    verify(folder)


def link_to_twin(folder: Path) -> None:
    """The same bytes, but through a link that leaves the folder."""
    (folder / "deep/a.bin").rename(folder.parent / "a.bin")
    (folder / "deep/a.bin").symlink_to(folder.parent / "a.bin")


def foreign_link(folder: Path) -> None:
    (folder / "way-out").symlink_to(folder.parent)


def list_says(line: str) -> Callable[[Path], object]:
    return lambda folder: (folder / CHECKSUMS).write_text(line)


ZEROS = "0" * 64
DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "cut": (lambda f: (f / "deep/a.bin").write_bytes(b""), "a.bin has sha256"),
    "longer": (lambda f: (f / "b with blanks.txt").write_text("bb"), "b with blanks.txt has"),
    "missing": (lambda f: (f / "deep/a.bin").unlink(), "a.bin is missing"),
    "foreign": (lambda f: (f / "deep/c.txt").write_text(""), "c.txt is foreign"),
    "foreign link": (foreign_link, "way-out is foreign"),
    "linked out": (link_to_twin, "a.bin is a link"),
    "a folder gone": (lambda f: shutil.rmtree(f / "deep"), "1 more files are amiss"),
    "no list": (lambda f: (f / CHECKSUMS).unlink(), f"cannot read .*{CHECKSUMS}"),
    "a list of nonsense": (list_says("hello"), "line 1 of"),
    "a list that leaves": (list_says(f"{ZEROS}  ../x\n"), "line 1 of"),
    "an absolute list": (list_says(f"{ZEROS}  /etc/passwd\n"), "line 1 of"),
    "a name twice": (list_says(f"{ZEROS}  x\n{ZEROS}  x\n"), "line 2 of"),
    "a list that is no text": (lambda f: (f / CHECKSUMS).write_bytes(b"\xff\xfe"), "not text"),
}


@pytest.mark.parametrize("case", DAMAGE)
def test_damage_is_named(case: str, folder: Path, run: Run) -> None:
    spoil, told = DAMAGE[case]
    spoil(folder)
    with pytest.raises(InputError, match=told):
        verify(folder)
    assert run("verify", folder, "--json").complaint


def test_no_folder(run: Run, tmp_path: Path) -> None:
    assert "no folder" in run("verify", tmp_path / "nowhere").complaint


def test_what_a_command_wrote_is_whole(small_capture: Path) -> None:
    assert verify(small_capture).files == 6


def test_a_list_may_be_long(tmp_path: Path) -> None:
    """Ten million frames are half a million files: a list of 66 MB."""
    line = f"{ZEROS}  train/i400-b00000-f0-e0/incandescent-0.25-30ms-"
    (tmp_path / CHECKSUMS).write_text("".join(f"{line}{k}.npy\n" for k in range(150_000)))
    assert len(read_checksums(tmp_path)) == 150_000
    with pytest.raises(InputError, match=r"is missing \(149999 more"):
        verify(tmp_path)
