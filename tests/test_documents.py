"""Strict documents: a key, a type or a bound that is wrong is refused by name."""

from __future__ import annotations

import datetime
import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import Field

from foundation import documents
from foundation.documents import NAME, STRICT, convert, parse_json, read_json, read_toml
from foundation.errors import DocumentError, InputError, unknown


@dataclass(frozen=True, kw_only=True)
class Part:
    weight_kg: Annotated[float, Field(gt=0)]

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Whole:
    name: str
    count: Annotated[int, Field(ge=1)] = 1
    part: tuple[Part, ...] = ()
    mark: Annotated[tuple[str, ...], Field(min_length=1)] = ("a",)
    file: Annotated[str, NAME] = "a"
    format: Annotated[str, Field(pattern="^x/1$")] = "x/1"

    __pydantic_config__ = STRICT

    def __post_init__(self) -> None:
        if self.name == "bad":
            raise InputError("bad", "expected good", "mend it")


GOOD = {"name": "a", "count": 2, "part": [{"weight_kg": 1.5}]}
WHOLE = {"name": "a", "part": [{"weight_kg": 2}]}


def test_a_good_document() -> None:
    assert convert(GOOD, Whole, "x") == Whole(name="a", count=2, part=(Part(weight_kg=1.5),))
    assert convert(WHOLE, Whole, "x") == Whole(name="a", part=(Part(weight_kg=2.0),))
    pointed = convert({**GOOD, "count": 2.0}, Whole, "x")
    assert pointed == convert(GOOD, Whole, "x")
    assert isinstance(pointed.count, int)


WRONG = {
    "unknown key": ({"name": "a", "cuont": 2}, "did you mean 'count'?"),
    "unknown key inside": ({"name": "a", "part": [{"weight": 1}]}, "did you mean 'weight_kg'?"),
    "missing key": ({"count": 2}, "add name"),
    "wrong type": ({"name": 3}, "name = 3"),
    "out of bounds": ({"name": "a", "count": 0}, "expected a number of at least 1"),
    "out of bounds inside": ({"name": "a", "part": [{"weight_kg": -1}]}, "part[0].weight_kg"),
    "text for a number": ({"name": "a", "count": "2"}, "expected a whole number"),
    "truth for a number": ({"name": "a", "count": True}, "expected a whole number"),
    "text for a figure": ({"name": "a", "part": [{"weight_kg": "1"}]}, "expected a number"),
    "truth for a figure": ({"name": "a", "part": [{"weight_kg": True}]}, "expected a number"),
    "a point in a count": ({"name": "a", "count": 2.5}, "expected a whole number"),
    "a date for text": ({"name": datetime.date(2000, 1, 1)}, "expected text in quotes"),
    "half a character": ({"name": "\ud800"}, "what no document can"),
    "one for a list": ({"name": "a", "part": 3}, "expected a list"),
    "no table": ({"name": "a", "part": [3]}, "expected a table"),
    "too few": ({"name": "a", "mark": []}, "expected at least 1 of them"),
    "no such spelling": ({"name": "a", "file": "../b"}, "file = '../b' in x; expected at most 100"),
    "another version": ({"name": "a", "format": "x/2"}, "expected 'x/1'; correct format"),
    "a key of any length": ({"name": "a", "k" * 5000: 2}, "kkk...kkk"),
    "what the document refuses itself": ({"name": "bad"}, "bad in x; expected good; mend it"),
    "infinite": ({"name": "a", "part": [{"weight_kg": float("inf")}]}, "part[0].weight_kg"),
    "not a number": ({"name": "a", "part": [{"weight_kg": float("nan")}]}, "part[0].weight_kg"),
    "not a table": ([1, 2], "x"),
    "nothing": (None, "x"),
}


@pytest.mark.parametrize("case", WRONG)
def test_refused(case: str) -> None:
    data, words = WRONG[case]
    with pytest.raises(DocumentError) as caught:
        convert(data, Whole, "x")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=12,
)


@settings(deadline=None, derandomize=True)
@given(plain | st.fixed_dictionaries({"name": plain}, optional={"part": plain, "count": plain}))
def test_any_data_is_a_document_or_one_line(data: object) -> None:
    refusal: DocumentError | None = None
    try:
        result = convert(data, Whole, "x")
    except DocumentError as error:
        refusal = error
    if refusal is None:
        assert isinstance(result, Whole)
    else:
        assert "\n" not in str(refusal)
        assert str(refusal).count("; ") >= 2


@settings(deadline=None, derandomize=True)
@given(content=st.binary(max_size=200))
def test_any_bytes_are_toml_or_one_line(
    content: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = Path(tmp_path_factory.mktemp("t") / "x.toml")
    file.write_bytes(content)
    with pytest.raises(DocumentError) as caught:
        read_toml(file, Whole)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["NaN", '{"a": Infinity}', "[1,", "", "[" * 100_000])
def test_json_that_is_none(text: str) -> None:
    with pytest.raises(DocumentError):
        parse_json(text, "x")


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    large = tmp_path / "large.json"
    large.write_text('"' + "a" * 100 + '"', encoding="utf-8")
    monkeypatch.setattr(documents, "MAX_DOCUMENT_BYTES", 50)
    for path, words in (
        (large, "102 bytes"),
        (tmp_path / "no", "No such file"),
        (tmp_path / "no" / "no", "No such file"),
    ):
        with pytest.raises(DocumentError, match=words):
            read_json(path, Whole)


def test_an_error_crosses_process_borders_whole() -> None:
    error = unknown("lamp", "incandecent", ["incandescent", "fluorescent"], DocumentError)
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is DocumentError
    assert str(copy) == str(error)
    assert isinstance(copy, InputError)
    assert copy.remedy == "did you mean 'incandescent'?"


def test_a_list_of_what_is_known_is_told_once() -> None:
    told = str(unknown("lamp", "moon", ["incandescent", "fluorescent"], DocumentError))
    assert told.count("incandescent") == 1
    assert "expected none" in str(unknown("lamp", "moon", [], DocumentError))


def test_an_error_is_one_line_whatever_it_is_told() -> None:
    assert str(InputError("a\nb", " c\t d", "e")) == "a b; c d; e"
