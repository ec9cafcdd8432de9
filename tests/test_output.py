"""Nothing is ever half-written: output appears whole, or not at all."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from foundation.errors import OutputError
from foundation.output import CHECKSUMS, new_file, new_folder, refuse_taken


class Interruption(BaseException):
    pass


FAILURES = (RuntimeError, Interruption)


def fill_file_and_fail(target: Path, failure: type[BaseException]) -> None:
    with new_file(target) as scratch:
        scratch.write_text("half", encoding="utf-8")
        raise failure


def fill_folder_and_fail(target: Path, failure: type[BaseException]) -> None:
    with new_folder(target) as scratch:
        (scratch / "a.txt").write_text("a", encoding="utf-8")
        raise failure


def fill_disk(target: Path) -> None:
    with new_folder(target), Path("/dev/full").open("w") as full:
        full.write("x")


def test_a_file_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "deep/er/x.txt"
    with new_file(target) as scratch:
        scratch.write_text("1", encoding="utf-8")
        assert not target.exists()
        assert scratch.suffix == target.suffix, "writers choose the format by it"
    assert target.read_text(encoding="utf-8") == "1"
    assert list(target.parent.iterdir()) == [target]


def test_a_file_stays_as_it_was_when_writing_fails(tmp_path: Path) -> None:
    target = tmp_path / "x.txt"
    target.write_text("old", encoding="utf-8")
    for failure in FAILURES:
        with pytest.raises(failure):
            fill_file_and_fail(target, failure)
    assert target.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_folder_appears_whole_with_checksums(tmp_path: Path) -> None:
    target = tmp_path / "made"
    with new_folder(target) as scratch:
        (scratch / "sub").mkdir()
        (scratch / "sub/a.txt").write_text("a", encoding="utf-8")
        (scratch / "b.txt").write_text("b", encoding="utf-8")
        assert not target.exists()
    assert {p.name for p in target.iterdir()} == {"sub", "b.txt", CHECKSUMS}
    subprocess.run(
        ["sha256sum", "--check", "--strict", "--quiet", CHECKSUMS], cwd=target, check=True
    )
    (target / "b.txt").write_text("c", encoding="utf-8")
    checked = subprocess.run(
        ["sha256sum", "--check", CHECKSUMS], cwd=target, check=False, capture_output=True
    )
    assert checked.returncode != 0
    assert list(tmp_path.iterdir()) == [target]


def test_no_folder_is_left_when_filling_it_fails(tmp_path: Path) -> None:
    for failure in FAILURES:
        with pytest.raises(failure):
            fill_folder_and_fail(tmp_path / "made", failure)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_replaced_only_when_the_new_one_is_whole(tmp_path: Path) -> None:
    target = tmp_path / "made"
    target.mkdir()
    (target / "old.txt").write_text("old", encoding="utf-8")
    with pytest.raises(OutputError, match="--overwrite"), new_folder(target):
        pytest.fail("the block must not run")
    with pytest.raises(RuntimeError), new_folder(target, overwrite=True):
        raise RuntimeError
    assert (target / "old.txt").exists()
    with new_folder(target, overwrite=True) as scratch:
        (scratch / "new.txt").write_text("new", encoding="utf-8")
    assert {p.name for p in target.iterdir()} == {"new.txt", CHECKSUMS}


def test_an_empty_folder_is_free(tmp_path: Path) -> None:
    (tmp_path / "made").mkdir()
    refuse_taken(tmp_path / "made", overwrite=False)


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    for place in (file / "x", Path("/proc/nowhere/x")):
        with pytest.raises(OutputError, match="--out"), new_folder(place):
            pytest.fail("the block must not run")
        with pytest.raises(OutputError), new_file(place):
            pytest.fail("the block must not run")
    with pytest.raises(OutputError, match="is a file"), new_folder(file, overwrite=True):
        pytest.fail("the block must not run")


def test_a_disk_that_fills_up_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="No space left"):
        fill_disk(tmp_path / "made")
    assert list(tmp_path.iterdir()) == []
