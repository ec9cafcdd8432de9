"""Whether a finished folder is still what it was: every file against its checksum."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from foundation.cores import in_order
from foundation.errors import InputError
from foundation.output import CHECKSUMS, LINE, sha256

MOST_IN_A_LINE = 8192
"""Characters of a line beyond which it is no path."""


class DamageError(InputError):
    """A folder is not what it was when it was made."""


@dataclass(frozen=True, kw_only=True)
class Whole:
    """What was checked of a folder in which nothing is amiss."""

    files: int
    size_bytes: int


def verify(folder: Path, progress: Callable[[int], None] = lambda files: None) -> Whole:
    """Check every file of a folder against its list of checksums.

    A flipped bit or a cut shows in the SHA-256 of a file; a file that is missing, or one that is
    not on the list, by its name. Nothing is followed out of the folder.

    Raises:
        DamageError: for the first file that is amiss, with the number of others; or when there is
            no list, or it is none.
    """
    if not folder.is_dir():
        raise InputError(f"no folder {folder}", f"expected one with {CHECKSUMS}", "check the path")
    expected = read_checksums(folder)
    present = {path.relative_to(folder).as_posix(): path for path in _files(folder)}
    problems = [(name, "is missing", "it") for name in expected if name not in present]
    problems += [
        (name, "is foreign", f"only files that {CHECKSUMS} lists")
        for name in sorted(present)
        if name not in expected and name != CHECKSUMS
    ]
    checked = [name for name in expected if name in present]
    size = 0

    def of_file(name: str) -> str:
        return _sum_or_reason(present[name])

    for name, found in zip(checked, in_order(of_file, checked), strict=True):
        if found != expected[name]:
            problems.append(
                (name, f"has sha256 {found}" if len(found) == 64 else found, expected[name])
            )
        else:
            size += present[name].stat().st_size
        progress(1)
    if problems:
        name, what, wanted = problems[0]
        others = f" ({len(problems) - 1} more files are amiss)" if len(problems) > 1 else ""
        raise DamageError(
            f"{folder / name} {what}{others}",
            f"expected {wanted}",
            "remove it" if what == "is foreign" else "copy the folder again, or make it anew",
        )
    return Whole(files=len(checked), size_bytes=size)


def _lines(path: Path) -> Iterator[str]:
    """The lines of a list, which may be long: half a million for ten million frames."""
    try:
        with path.open(encoding="utf-8") as stream:
            while line := stream.readline(MOST_IN_A_LINE):
                yield line.removesuffix("\n")
    except OSError as problem:
        raise DamageError(
            f"cannot read {path} ({problem.strerror or problem})",
            "expected the list of checksums of a finished folder",
            "check the path and its permissions",
        ) from None
    except UnicodeDecodeError:
        raise DamageError(
            f"{path} is not text", "expected UTF-8", "copy the folder again, or make it anew"
        ) from None


def _sum_or_reason(path: Path) -> str:
    try:
        if path.is_symlink() or not path.is_file():
            return "is a link or no plain file"
        return sha256(path)
    except OSError as problem:
        return f"cannot be read ({problem.strerror or problem})"


def _files(folder: Path) -> Iterator[Path]:
    """Everything below a folder that is no folder; links are told, not followed."""
    for root, folders, names in os.walk(folder):
        links = [name for name in folders if (Path(root) / name).is_symlink()]
        for name in [*names, *links]:
            yield Path(root) / name


def read_checksums(folder: Path) -> dict[str, str]:
    """The list of checksums of a folder: SHA-256 by path.

    Raises:
        DamageError: for a list that is missing or no text, a line that is none, a path listed
            twice or one that leaves the folder.
    """
    path = folder / CHECKSUMS
    sums: dict[str, str] = {}
    for number, line in enumerate(_lines(path), start=1):
        match = LINE.fullmatch(line)
        name = match[2] if match else ""
        steps = PurePosixPath(name)
        if not match or steps.is_absolute() or ".." in steps.parts or name in sums or "\0" in name:
            raise DamageError(
                f"line {number} of {path} is '{line[:100]}'",
                "expected a SHA-256, two spaces, and a path inside the folder, each path once",
                "copy the folder again, or make it anew",
            )
        sums[name] = match[1]
    return sums
