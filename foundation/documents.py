"""Strict reading of the TOML and JSON documents that people and programs write.

A document is a frozen, keyword-only dataclass; pydantic checks every key, type and bound.
An unknown key is refused by name, never ignored.
"""

from __future__ import annotations

import contextlib
import functools
import json
import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

import pydantic
from pydantic_core import ErrorDetails

from foundation.errors import DocumentError, InputError, nearest

T = TypeVar("T")

STRICT = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
"""Put ``__pydantic_config__ = STRICT`` in a dataclass to make it a document: a number is no text,
and no truth value; 3 will do for 3.0, and 3.0 for 3."""

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
        # As JSON, since strict Python data would have to be tuples and dataclasses already.
        text = json.dumps(data, default=lambda moment: {"date or time": str(moment)})
    except (ValueError, RecursionError) as problem:
        raise _no_document(source, str(problem)) from None
    try:
        return _validated(text, kind)
    except pydantic.ValidationError as problem:
        problems = problem.errors(include_url=False)
        # A misspelt key is both unknown and missing: its spelling is what to mend.
        first = next((each for each in problems if each["type"] in _UNKNOWN), problems[0])
        if first["type"] == "json_invalid":
            raise _no_document(source, first["ctx"]["error"]) from None
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
        if isinstance(error := first.get("ctx", {}).get("error"), InputError):
            raise DocumentError(
                f"{error.found} in {source}", error.expected, error.remedy
            ) from None
        shown = repr(first["input"])
        shown = shown if len(shown) <= 60 else shown[:57] + "..."
        raise DocumentError(
            f"{where} = {shown} in {source}", _expected(first), f"correct {where}"
        ) from None


def _validated(text: str, kind: type[T]) -> T:
    """A document of JSON; 40.0 will do for 40, as programs write it that count in floats."""
    adapter = _adapter(kind)  # type: ignore[arg-type]
    try:
        return adapter.validate_json(text)  # type: ignore[no-any-return]
    except pydantic.ValidationError as problem:
        pointed = [
            each["loc"]
            for each in problem.errors(include_url=False)
            if each["type"] == "int_type"
            and isinstance(each["input"], float)
            and each["input"].is_integer()
        ]
        if not pointed:
            raise
    data = json.loads(text)
    for *way, last in pointed:
        with contextlib.suppress(KeyError, IndexError, TypeError):  # a way through alternatives
            holder = functools.reduce(lambda inside, step: inside[step], way, data)
            holder[last] = int(holder[last])
    return adapter.validate_json(json.dumps(data))  # type: ignore[no-any-return]


_EXPECTED = {
    "dataclass_type": "a table",
    "dict_type": "a table",
    "finite_number": "a finite number",
    "float_type": "a number",
    "greater_than": "a number above {gt:g}",
    "greater_than_equal": "a number of at least {ge:g}",
    "int_from_float": "a whole number",
    "int_type": "a whole number",
    "less_than": "a number below {lt:g}",
    "less_than_equal": "a number of at most {le:g}",
    "literal_error": "{expected}",
    "string_too_long": "text of at most {max_length} characters",
    "string_too_short": "text of at least {min_length} characters",
    "string_type": "text in quotes",
    "too_long": "at most {max_length} of them",
    "too_short": "at least {min_length} of them",
    "tuple_type": "a list",
}
"""What pydantic's kinds of error ask for."""


def _expected(error: ErrorDetails) -> str:
    """What should stand there, in words; a validator of ours says it itself."""
    kind, context = error["type"], error.get("ctx", {})
    if kind == "string_pattern_mismatch":
        return f"expected '{context['pattern'].removeprefix('^').removesuffix('$')}'"
    if kind in _EXPECTED:
        return "expected " + _EXPECTED[kind].format(**context)
    message = error["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    return message if message.startswith("expected ") else f"expected {message}"


def spelt(pattern: str, words: str) -> pydantic.AfterValidator:
    """Text of a pattern; `words` tell people which."""

    def check(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise ValueError(f"expected {words}")
        return text

    return pydantic.AfterValidator(check)


NAME = spelt(
    r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}",
    "at most 100 letters, digits, dots and dashes, a letter or digit first",
)
"""How things are called that become names of files."""


def _no_document(source: str, problem: str) -> DocumentError:
    return DocumentError(
        f"{source} holds what no document can ({problem})",
        "expected text, numbers and lists of ordinary size",
        "correct it",
    )


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
    except (ValueError, RecursionError) as problem:
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
