"""Input that was right, damaged, and what is asked of an answer to it."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from camtruth.command import main
from foundation.errors import InputError

CASES = int(os.environ.get("CAMTRUTH_CASES", "300"))
PATIENCE_S = 30.0
"""A case that takes longer hangs; the slowest take a second on a busy machine."""


def share(part: float) -> settings:
    """So many of the cases."""
    return settings(
        max_examples=max(5, round(CASES * part)),
        deadline=None,
        derandomize="CAMTRUTH_CASES" not in os.environ,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


EXTREMES = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)
WORDS = (
    "-1", "0", "1e400", "-1e-300", "nan", "inf", '""', '"x"', '"../../etc/passwd"', "[]", "{}",
    "true", "9" * 400, "1979-05-27", '"\\u0000"', '"' + "a" * 5000 + '"', "[" * 300, "[[1, 2], 3]",
    '"*/**/x**"', '"/dev/zero"', '"none"', '["none", "none"]', "3.5", "4294967296",
)  # fmt: skip


@st.composite
def damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """Bytes with one to four injuries."""
    made = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(0, len(made) - 1)))
        kind = draw(st.sampled_from(("flip", "cut", "insert", "zero", "extreme", "repeat", "gone")))
        if kind == "flip" and made:
            made[at] ^= 1 << draw(st.integers(0, 7))
        elif kind == "cut":
            del made[at:]
        elif kind == "insert":
            made[at:at] = draw(st.binary(max_size=40))
        elif kind == "zero":
            made[at : at + 16] = bytes(len(made[at : at + 16]))
        elif kind == "extreme":
            size, order = draw(st.sampled_from((1, 2, 4, 8))), draw(st.sampled_from(("<", ">")))
            number = draw(st.sampled_from(EXTREMES)) % 256**size
            made[at : at + size] = number.to_bytes(size, "little" if order == "<" else "big")
        elif kind == "repeat":
            made[at:at] = made[at : at + 64]
        else:
            del made[at : at + draw(st.integers(1, 64))]
    return bytes(made)


@st.composite
def misspelt(draw: st.DrawFn, text: str) -> bytes:
    """A document with one to three values, keys or lines that are not right."""
    lines = text.splitlines()
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(lines) - 1))
        kind = draw(st.sampled_from(("value", "key", "gone", "twice", "junk", "bytes")))
        if kind == "value" and "=" in lines[at]:
            lines[at] = lines[at].partition("=")[0] + "= " + draw(st.sampled_from(WORDS))
        elif kind == "key":
            lines[at] = draw(st.text(max_size=8)) + lines[at]
        elif kind == "gone" and len(lines) > 1:
            del lines[at]
        elif kind == "twice":
            lines.insert(at, lines[at])
        elif kind == "junk":
            lines.insert(at, draw(st.text(max_size=40)))
    whole = "\n".join(lines).encode("utf-8", "surrogatepass")
    return draw(damaged(whole)) if draw(st.integers(0, 4)) == 0 else whole


def answer(*words: object) -> int:
    """Run a command line; it must keep its word about errors."""
    out, err = io.StringIO(), io.StringIO()
    started = time.monotonic()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    assert time.monotonic() - started < PATIENCE_S, words
    assert code in (0, 2), (words, err.getvalue())
    if code == 2:
        assert out.getvalue() == "", words
        line = err.getvalue()
        assert re.fullmatch(r"camtruth: error: [^\n]*; [^\n]*; [^\n]*\n", line), (words, line)
    return code


def refused_or_read(read: Callable[[], object]) -> None:
    """A reader gives something, or an error for people of one line."""
    started = time.monotonic()
    told = ""
    try:
        read()
    except InputError as error:
        told = str(error)
    assert "\n" not in told
    assert time.monotonic() - started < PATIENCE_S


def everything_in(folder: Path, but: Path) -> dict[str, int]:
    """Size of every file below a folder, but those below another."""
    return {
        str(path): path.stat().st_size
        for path in folder.rglob("*")
        if path.is_file() and but not in path.parents
    }


@contextlib.contextmanager
def sandbox(folder: Path) -> Any:
    """A copy of a folder, and an output folder beside it: nothing else may change."""
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        shutil.copytree(folder, home / "in")
        with contextlib.chdir(home):
            yield home / "in"
        names = {path.name for path in home.iterdir()}
        assert names <= {"in", "out", "camtruth-out"}, names
