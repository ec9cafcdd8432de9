"""Strict reading of the TOML and JSON documents that people and programs write.

A document is a frozen, keyword-only dataclass; pydantic checks every key, type and bound.
An unknown key is refused by name, never ignored.
"""

from __future__ import annotations

import functools
import json
import tomllib
from pathlib import Path
from typing import Any, TypeVar

import pydantic

from foundation.errors import DocumentError, nearest

T = TypeVar("T")

STRICT = pydantic.ConfigDict(extra="forbid", strict=False, allow_inf_nan=False)
"""Put ``__pydantic_config__ = STRICT`` in a dataclass to make it a document."""

MAX_DOCUMENT_BYTES = 16_000_000
"""A text document larger than this is a mistake or an attack."""

_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")


@functools.cache
def _adapter(kind: type[Any]) -> pydantic.TypeAdapter[Any]:
    return pydantic.TypeAdapter(kind)


def _keys_at(kind: Any, location: tuple[Any, ...]) -> list[str]:
    """The keys that the document's schema knows at a location, for the remedy."""
    schema = _adapter(kind).json_schema()
    node = schema
    for step in location:
        while "$ref" in node:
            node = schema["$defs"][node["$ref"].rsplit("/", 1)[1]]
        if isinstance(step, int):
            node = node.get("items", {})
        else:
            node = node.get("properties", {}).get(step, node)
    while "$ref" in node:
        node = schema["$defs"][node["$ref"].rsplit("/", 1)[1]]
    return list(node.get("properties", {}))


def _path(location: tuple[Any, ...]) -> str:
    text = ""
    for step in location:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else str(step)
    return text or "the document"


def convert(data: Any, kind: type[T], source: str) -> T:
    """Check plain data (dicts, lists, numbers) against a document type.

    Raises:
        DocumentError: with the key, what stands there, what may stand there.
    """
    try:
        return _adapter(kind).validate_python(data)  # type: ignore[no-any-return, arg-type]
    except pydantic.ValidationError as problem:
        problems = problem.errors(include_url=False)
        # A misspelt key is both unknown and missing: its spelling is what to mend.
        first = next((each for each in problems if each["type"] in _UNKNOWN), problems[0])
        location = tuple(first["loc"])
        where = _path(location)
        if first["type"] in _UNKNOWN:
            keys = _keys_at(kind, location[:-1])
            raise DocumentError(
                f"unknown key '{where}' in {source}",
                f"expected one of {', '.join(keys)}" if keys else "expected no such key",
                nearest(str(location[-1]), keys) if keys else "remove it",
            ) from None
        if first["type"] in ("missing", "missing_argument", "missing_keyword_only_argument"):
            raise DocumentError(
                f"no key '{where}' in {source}", "it is required", f"add {where} = ..."
            ) from None
        shown = repr(first["input"])
        shown = shown if len(shown) <= 60 else shown[:57] + "..."
        message = first["msg"].removeprefix("Value error, ").rstrip(".")
        raise DocumentError(
            f"{where} = {shown} in {source}",
            message[:1].lower() + message[1:],
            f"correct {where}",
        ) from None


def read_text(path: Path) -> str:
    """A text document's content, with its size limited.

    Raises:
        DocumentError: when it is missing, unreadable, too large, or not UTF-8.
    """
    try:
        if path.stat().st_size > MAX_DOCUMENT_BYTES:
            raise DocumentError(
                f"{path} has {path.stat().st_size} bytes",
                f"expected a text document of at most {MAX_DOCUMENT_BYTES} bytes",
                "check that this is the file you mean",
            )
        return path.read_text(encoding="utf-8")
    except OSError as problem:
        raise DocumentError(
            f"cannot read {path} ({problem.strerror or problem})",
            "expected a readable file",
            "check the path and its permissions",
        ) from None
    except UnicodeDecodeError:
        raise DocumentError(
            f"{path} is not text", "expected UTF-8", "check that this is the file you mean"
        ) from None


def read_toml(path: Path, kind: type[T]) -> T:
    """Read a TOML document strictly; see `convert`."""
    text = read_text(path)
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as problem:
        raise DocumentError(
            f"{path} is not TOML ({problem})", "expected valid TOML", "correct that line"
        ) from None
    return convert(data, kind, str(path))


def parse_json(text: str, source: str) -> Any:
    """Plain data from JSON text; NaN and infinities are refused.

    Raises:
        DocumentError: when the text is not JSON.
    """

    def refuse(name: str) -> float:
        raise ValueError(f"{name} is not a JSON number")

    try:
        return json.loads(text, parse_constant=refuse)
    except (ValueError, RecursionError) as problem:
        raise DocumentError(
            f"{source} is not JSON ({problem})", "expected valid JSON", "make the file anew"
        ) from None


def read_json(path: Path, kind: type[T]) -> T:
    """Read a JSON document strictly; see `convert`."""
    return convert(parse_json(read_text(path), str(path)), kind, str(path))
