"""Writing so that nothing is ever half-written: build beside, then rename into place."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from foundation.errors import OutputError

CHECKSUMS = "SHA256SUMS"
"""Name of the checksum list of a finished folder, in the format of `sha256sum`."""


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
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
        )
        os.close(handle)
    except OSError as problem:
        raise _unwritable(path, problem) from None
    scratch = Path(name)
    try:
        yield scratch
        scratch.chmod(0o644)
        scratch.replace(path)
    except OSError as problem:
        raise _unwritable(path, problem) from None
    finally:
        scratch.unlink(missing_ok=True)


@contextlib.contextmanager
def new_folder(path: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """A temporary folder to fill, checksummed and moved to `path` when the block ends well.

    Raises:
        OutputError: when `path` is taken and not to be overwritten, or cannot be written.
    """
    refuse_taken(path, overwrite=overwrite)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    except OSError as problem:
        raise _unwritable(path, problem) from None
    try:
        yield scratch
        write_checksums(scratch)
        scratch.chmod(0o755)
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        scratch.replace(path)
    except OSError as problem:
        raise _unwritable(path, problem) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def refuse_taken(path: Path, *, overwrite: bool) -> None:
    """Refuse a folder that holds something, unless it may be overwritten.

    Raises:
        OutputError: when `path` is a file, or a folder that is not empty.
    """
    if path.exists() and not path.is_dir():
        raise OutputError(f"{path} is a file", "expected a folder", "choose another with --out")
    if path.is_dir() and any(path.iterdir()) and not overwrite:
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
    """Write `SHA256SUMS` for every file below a folder, lists of its subfolders among them."""
    own = folder / CHECKSUMS
    files = sorted(p for p in folder.rglob("*") if p.is_file() and p != own)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        sums = list(pool.map(sha256, files))
    pairs = zip(sums, files, strict=True)
    lines = [f"{found}  {path.relative_to(folder).as_posix()}\n" for found, path in pairs]
    own.write_text("".join(lines), encoding="utf-8")
