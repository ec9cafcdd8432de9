"""Errors for people: what was found, what was expected, what to do.

InputError                     anything a user can mend; commands answer it with exit code 2
├── DocumentError              a file that people write says something it may not
├── OutputError                the place to write to cannot be written
├── scenes.errors.SceneError   each folder keeps its own branch in its own errors.py
├── render.errors.RenderError
├── sensor.errors.SensorError
└── analysis.errors.AnalysisError
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

_LONG = re.compile(r"(\S{150})\S{100,}(\S{50})")
"""A word that nobody reads to its end."""


class InputError(ValueError):
    """Bad input, told in three parts, each a plain phrase without a full stop.

    `str(error)` is one line: ``found; expected; remedy``.
    """

    def __init__(self, found: str, expected: str, remedy: str) -> None:
        self.found, self.expected, self.remedy = (
            _LONG.sub(r"\1...\2", " ".join(part.split())) for part in (found, expected, remedy)
        )
        super().__init__(f"{self.found}; {self.expected}; {self.remedy}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str]]:
        """Pickle by parts, so that the error crosses process borders whole."""
        return type(self), (self.found, self.expected, self.remedy)


class DocumentError(InputError):
    """A TOML or JSON document holds something that its format does not allow."""


class OutputError(InputError):
    """The output folder or file cannot be written as asked."""


def nearest(word: str, choices: Iterable[str]) -> str:
    """A remedy that names the closest of the valid spellings, which the error lists.

    >>> nearest("incandecent", ["incandescent", "fluorescent"])
    "did you mean 'incandescent'?"
    """
    known = sorted(choices)
    close = difflib.get_close_matches(word, known, n=1)
    return f"did you mean '{close[0]}'?" if close else "choose one of them"


def unknown(kind: str, word: str, choices: Iterable[str], error: type[InputError]) -> InputError:
    """The error for a name that is not among the known ones of its kind."""
    known = sorted(choices)
    if not known:
        return error(f"unknown {kind} '{word}'", "expected none, as there are none", "leave it out")
    return error(
        f"unknown {kind} '{word}'", f"expected one of {', '.join(known)}", nearest(word, known)
    )
