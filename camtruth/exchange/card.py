"""The dataset card: Croissant JSON-LD, which search engines and loaders read.

Reference: MLCommons, Croissant Format Specification 1.0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from foundation.output import CHECKSUMS, sha256

CARD = "croissant.json"
CONFORMS_TO = "http://mlcommons.org/croissant/1.0"

CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}

MEDIA_TYPES = {
    ".csv": "text/csv",
    ".exr": "image/x-exr",
    ".json": "application/json",
    ".md": "text/markdown",
    ".npy": "application/octet-stream",
    ".toml": "application/toml",
    ".txt": "text/plain",
}


def licence_url(spdx: str) -> str:
    """Where the text of a licence stands, by its SPDX identifier."""
    return f"https://spdx.org/licenses/{spdx}.html"


def card(
    folder: Path,
    *,
    name: str,
    description: str,
    licence: str,
    version: str,
    tables: Mapping[str, tuple[str, Mapping[str, str]]],
    frames: Iterable[tuple[str, str, str]] = (),
) -> dict[str, Any]:
    """A card for a folder whose other files are written.

    Args:
        folder: the folder.
        name, description, version: of the dataset.
        licence: SPDX identifier.
        tables: CSV files by the name of their records: file, and the type of each column.
        frames: sets of files: name, pattern below the folder, media type.
    """
    patterns = list(frames)
    single = [
        path
        for path in sorted(folder.iterdir())
        if path.is_file() and path.name not in (CARD, CHECKSUMS)
    ]
    return {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "name": name,
        "conformsTo": CONFORMS_TO,
        "description": description,
        "license": licence_url(licence),
        "version": version,
        "isLiveDataset": False,
        "distribution": [
            *(_file(path) for path in single),
            *(_file_set(*pattern) for pattern in patterns),
        ],
        "recordSet": [_records(key, file, columns) for key, (file, columns) in tables.items()],
    }


def _file(path: Path) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": path.name,
        "name": path.name,
        "contentUrl": path.name,
        "contentSize": f"{path.stat().st_size} B",
        "encodingFormat": MEDIA_TYPES.get(path.suffix, "application/octet-stream"),
        "sha256": sha256(path),
    }


def _file_set(name: str, pattern: str, media_type: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": name,
        "name": name,
        "encodingFormat": media_type,
        "includes": pattern,
    }


def _records(key: str, file: str, columns: Mapping[str, str]) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": key,
        "name": key,
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{key}/{column}",
                "name": column,
                "dataType": f"sc:{kind}",
                "source": {"fileObject": {"@id": file}, "extract": {"column": column}},
            }
            for column, kind in columns.items()
        ],
    }
