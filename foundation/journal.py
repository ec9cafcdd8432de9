"""A file that keeps results as they come, so that a run that was killed goes on where it stopped.

One line of JSON for each result, forced to disk before the next is waited for. The first line says
which question the results answer; results of another question are refused, not mixed in. A last
line that was cut off in the middle is dropped.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from foundation.claim import claim
from foundation.documents import parse_json
from foundation.errors import OutputError
from foundation.output import new_file

FORMAT = "camtruth-journal/1"


@dataclass(frozen=True, kw_only=True)
class Journal:
    """An open journal.

    Attributes:
        results: what it held when it was opened, by key.
        stream: where further lines go.
    """

    results: dict[str, Any] = field(default_factory=dict)
    stream: IO[bytes]

    @staticmethod
    @contextlib.contextmanager
    def open(path: Path, question: str) -> Iterator[Journal]:
        """Open a journal, or begin one.

        Raises:
            OutputError: when it holds the results of another question, is none, cannot be
                written, or is being written by another run.
        """
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("r+b" if path.exists() else "xb") as stream:
                claim(stream, path)
                whole, results = _read(path, question)
                stream.truncate(whole)
                stream.seek(whole)
                journal = Journal(results=results, stream=stream)
                if whole == 0:
                    journal._line({"format": FORMAT, "question": question})
                yield journal
        except OSError as problem:
            raise OutputError(
                f"cannot write {path} ({problem.strerror or problem})",
                "expected a place that can be written",
                "choose another with --out, or make room and run it again with --resume",
            ) from None

    def append(self, key: str, result: Any) -> Any:
        """Keep a result; returns it as a reader of the file would see it."""
        self._line({"key": key, "result": result})
        return json.loads(json.dumps(result))

    def _line(self, document: dict[str, Any]) -> None:
        self.stream.write(json.dumps(document, allow_nan=False).encode() + b"\n")
        self.stream.flush()
        os.fsync(self.stream.fileno())


def put_in_order(path: Path, keys: Iterable[str]) -> None:
    """Sort the lines of a journal of these keys: the same bytes, whoever came first.

    One that holds others as well is left as it is: it grows from run to run.

    Raises:
        OutputError: when it cannot be written.
    """
    head, *lines = path.read_bytes().splitlines(keepends=True)
    by_key = {json.loads(line)["key"]: line for line in lines}
    wanted = list(keys)
    if set(wanted) == set(by_key) and list(by_key) != wanted:
        ordered = [by_key[key] for key in wanted]
        with new_file(path) as scratch:
            scratch.write_bytes(b"".join([head, *ordered]))


def _read(path: Path, question: str) -> tuple[int, dict[str, Any]]:
    """How many bytes are whole lines, and the results in them."""
    content = path.read_bytes()
    whole = content.rfind(b"\n") + 1
    lines = content[:whole].splitlines()
    if not lines:
        return 0, {}
    entries = [
        parse_json(line.decode(errors="replace"), f"line {number} of {path}")
        for number, line in enumerate(lines, start=1)
    ]
    if not all(isinstance(entry, dict) for entry in entries) or entries[0].get("format") != FORMAT:
        raise OutputError(
            f"{path} is no journal", f"expected format {FORMAT}", "choose another --out"
        )
    if entries[0].get("question") != question:
        raise OutputError(
            f"{path} holds results of another question",
            "expected the same cases, seeds, cameras and versions as before",
            "give the options of the first run, or start anew with --overwrite",
        )
    return whole, {entry["key"]: entry["result"] for entry in entries[1:]}
