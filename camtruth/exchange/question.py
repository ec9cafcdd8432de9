"""What an export or an import was asked, so that a run goes on only with what answers the same.

Source files are told by name, size and time of change: reading them all again would cost as much
as what is saved. The libraries' versions are in it because they decide the bytes.
"""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

LIBRARIES = ("camtruth", "numpy", "pillow", "tifffile", "astropy", "zarr", "av", "rawpy")


def question(asked: Mapping[str, object], files: Iterable[Path]) -> str:
    """What is asked of which files, by which versions, as one text."""
    known = [(str(p.resolve()), p.stat().st_size, p.stat().st_mtime_ns) for p in _flat(files)]
    document = {**asked, "files": known, "versions": dict(_versions())}
    return json.dumps(document, sort_keys=True, default=repr)


def _flat(paths: Iterable[Path]) -> Iterator[Path]:
    """Files, with those of folders; what is missing is left for whoever reads it to report."""
    for path in paths:
        if path.is_dir():
            yield from sorted(each for each in path.rglob("*") if each.is_file())
        elif path.exists():
            yield path


def _versions() -> Iterator[tuple[str, str]]:
    for name in LIBRARIES:
        try:
            yield name, importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
