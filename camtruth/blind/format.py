"""The documents of a withheld set, as other programs read and write them.

SET/set.toml            who takes part, case by case, and the commitment
SET/cases/NAME/         a capture folder, without its truth
SET/cases/NAME/nominal.toml   the camera's data sheet: each figure some 2 % off
SET.answers/NAME.json   a gap report for each case
SET.answers/SHA256SUMS  the answers' hashes: who has written it has answered
SET.seal/truth.json     the truth with its salt; its SHA-256 is the commitment
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import tomli_w
from pydantic import Field

from camtruth.blind.errors import BlindError
from foundation.documents import STRICT, read_json, read_toml
from foundation.output import sha256

SET_FORMAT = "camtruth-blind/1"
SEAL_FORMAT = "camtruth-seal/1"
SCORE_FORMAT = "camtruth-blind-score/1"

MANIFEST = "set.toml"
CASES = "cases"
NOMINAL = "nominal.toml"
TRUTH = "truth.json"

OPAQUE = r"^[0-9a-f]{10}$"

GROUPS = {
    "null": "nothing is wrong",
    "own": "an effect of the catalogue",
    "pair": "two effects of the catalogue",
    "left-out": "an effect of the catalogue that may not be suspected",
    "decoy": "an effect of the catalogue, while another may not be suspected",
    "put-back": "the camera and effect of a left-out case again, in a fresh capture",
    "others": "other people's code for an effect of the catalogue",
    "strange": "an effect that is in no catalogue",
}
"""Kinds of case."""


@dataclass(frozen=True, kw_only=True)
class CaseEntry:
    """A case as the set tells it.

    Attributes:
        name: opaque; also its folder.
        without: effects that may not be suspected.
    """

    name: Annotated[str, Field(pattern=OPAQUE)]
    without: tuple[str, ...] = ()

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class SetDocument:
    """`set.toml`."""

    format: Annotated[str, Field(pattern=f"^{SET_FORMAT}$")]
    name: str
    commitment: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    missing_sources: tuple[str, ...] = ()
    case: Annotated[tuple[CaseEntry, ...], Field(min_length=1)]

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class TrueEffect:
    """What was added to a camera.

    Attributes:
        name: its own name.
        answers: names that are right; empty where only "unexplained" is.
        stage: where in the signal path it acts.
        source: "own", a library, or "none".
        parameters: as they were set.
        severity: in detection limits; see `camtruth.blind.ruler`.
        absorbed: part of its signature that calibration takes up.
    """

    name: str
    answers: tuple[str, ...]
    stage: str
    source: str
    parameters: dict[str, float | dict[str, float]]
    severity: float
    absorbed: float

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class CaseTruth:
    """The truth of a case.

    Attributes:
        group: one of `GROUPS`.
        camera: the preset that its body is like.
        seed, body_seed: of the capture.
        effects: what was added.
        without: effects that may not be suspected.
        twin: the left-out case that a put-back case belongs to.
        figures: base figures of the camera.
    """

    group: str
    camera: str
    seed: int
    body_seed: int
    effects: tuple[TrueEffect, ...] = ()
    without: tuple[str, ...] = ()
    twin: str | None = None
    figures: dict[str, Any] = field(default_factory=dict)

    __pydantic_config__ = STRICT

    @property
    def severity(self) -> float:
        """Of the weakest effect, in detection limits; 0 without any."""
        return min((effect.severity for effect in self.effects), default=0.0)


@dataclass(frozen=True, kw_only=True)
class SealDocument:
    """`truth.json` of the seal."""

    format: Annotated[str, Field(pattern=f"^{SEAL_FORMAT}$")]
    salt: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    secret: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    seed: int
    cases: dict[str, CaseTruth]

    __pydantic_config__ = STRICT


def beside(folder: Path, what: str) -> Path:
    """The folder of a set's answers, seal or score: its neighbour with that ending."""
    return folder.with_name(f"{folder.name}.{what}")


def read_set(folder: Path) -> SetDocument:
    """A set's manifest.

    Raises:
        BlindError: when there is no such folder.
        DocumentError: when its manifest is none.
    """
    if not folder.is_dir():
        raise BlindError(
            f"no folder {folder}", f"expected a withheld set with {MANIFEST}", "check the path"
        )
    document = read_toml(folder / MANIFEST, SetDocument)
    names = [case.name for case in document.case]
    if len(set(names)) < len(names):
        raise BlindError(
            f"a case twice in {folder / MANIFEST}", "expected each once", "make the set anew"
        )
    return document


def write_set(folder: Path, document: SetDocument) -> None:
    """Write `set.toml`."""
    cases = [
        {"name": c.name, **({"without": list(c.without)} if c.without else {})}
        for c in document.case
    ]
    told = {
        "format": document.format,
        "name": document.name,
        "commitment": document.commitment,
        "missing_sources": list(document.missing_sources),
        "case": cases,
    }
    (folder / MANIFEST).write_text(tomli_w.dumps(told), encoding="utf-8")


def open_seal(folder: Path, commitment: str) -> SealDocument:
    """The truth, if it is the one that the set was published with.

    Raises:
        BlindError: when it is missing or another.
        DocumentError: when it is no seal.
    """
    path = folder / TRUTH
    if not path.is_file():
        raise BlindError(
            f"no seal {path}", "expected the truth of the set", "name its folder with --seal"
        )
    if sha256(path) != commitment:
        raise BlindError(
            f"{path} is not the truth that the set was published with",
            f"expected its SHA-256 to be {commitment}",
            "take the seal that was made with this set",
        )
    return read_json(path, SealDocument)
