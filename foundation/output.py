"""Writing so that nothing is ever half-written: build beside, then rename into place."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from foundation.cores import in_order
from foundation.errors import OutputError
from foundation.scratch import scratch

CHECKSUMS = "SHA256SUMS"
"""Name of the checksum list of a finished folder, in the format of `sha256sum`."""

LINE = re.compile(r"([0-9a-f]{64}) [ *](\S.*)")
"""A line of that list: the sum, and the path."""


def _unwritable(path: Path, problem: OSError) -> OutputError:
    return OutputError(
        f"cannot write {path} ({problem.strerror or problem})",
        "expected a place that can be written",
        "choose another with --out",
    )


@contextlib.contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """A temporary path to write to, moved to `path` when the block ends without an error.

    Raises:
        OutputError: when the place cannot be written.
    """
    try:
        with scratch(path, folder=False) as made:
            yield made
            made.chmod(0o644)
            made.replace(path)
    except OSError as problem:
        raise _unwritable(path, problem) from None


@contextlib.contextmanager
def new_folder(path: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """A temporary folder to fill, checksummed and moved to `path` when the block ends well.

    Raises:
        OutputError: when `path` is taken and not to be overwritten, or cannot be written.
    """
    refuse_taken(path, overwrite=overwrite)
    try:
        with scratch(path, folder=True) as made:
            yield made
            write_checksums(made)
            made.chmod(0o755)
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            made.replace(path)
    except OSError as problem:
        raise _unwritable(path, problem) from None


def refuse_taken(path: Path, *, overwrite: bool) -> None:
    """Refuse a folder that holds something, unless it may be overwritten.

    Raises:
        OutputError: when `path` is a file, a folder that is not empty, or one that cannot be.
    """
    try:
        there, empty = path.exists(), not (path.is_dir() and any(path.iterdir()))
    except OSError as problem:
        raise _unwritable(path, problem) from None
    if there and not path.is_dir():
        raise OutputError(f"{path} is a file", "expected a folder", "choose another with --out")
    if not empty and not overwrite:
        raise OutputError(
            f"{path} is not empty",
            "expected a new or empty folder",
            "choose another with --out, or pass --overwrite",
        )


def sha256(path: Path) -> str:
    """The SHA-256 of a file's bytes, in hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def write_checksums(folder: Path) -> None:
    """Write `SHA256SUMS` for every file below a folder.

    A subfolder that has such a list is finished: its list is taken over, and it is not read again.
    """
    own = folder / CHECKSUMS
    known: dict[Path, str] = {}
    to_read: list[Path] = []
    for root, folders, names in os.walk(folder):
        here = Path(root)
        finished = _finished(here) if here != folder and CHECKSUMS in names else None
        if finished is None:
            to_read += [here / name for name in names if here / name != own]
        else:
            known |= finished
            to_read.append(here / CHECKSUMS)
            folders.clear()
    known |= zip(to_read, in_order(sha256, to_read), strict=True)
    lines = [f"{known[path]}  {path.relative_to(folder).as_posix()}\n" for path in sorted(known)]
    own.write_text("".join(lines), encoding="utf-8")


def _finished(folder: Path) -> dict[Path, str] | None:
    """Checksums by path from the list of a finished folder; None where it is no such list."""
    matches = [LINE.fullmatch(line) for line in (folder / CHECKSUMS).read_text().splitlines()]
    known = {folder / match[2]: match[1] for match in matches if match}
    present = {path for path in folder.rglob("*") if path.is_file() and path.name != CHECKSUMS}
    return known if len(known) == len(matches) and set(known) == present else None
