"""The page on withheld effects: its text, and the tables of all sets that were scored.

    python -m docs.withheld_page [SCORE ANSWERED_BY]

A score is kept with the commit that answered; without one the page is written anew.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from camtruth.blind.marks import Mark
from camtruth.blind.scoring import markdown, marks_of
from camtruth.blind.table import OTHERS, OWN, table
from foundation.errors import InputError
from foundation.output import new_file

HERE = Path(__file__).parent
TEXT = HERE / "withheld_text.md"
RESULTS = HERE / "results" / "withheld"
PAGE = HERE / "withheld.md"

TOGETHER = 5
"""Sets, the last ones, whose cases are counted together: one has too few for its bands."""

BASELINES = ("histogram", "refit-free")

Document = Mapping[str, Any]


def sets() -> dict[int, Document]:
    """The scores that were published, by the number of their set."""
    return {
        int(path.stem): json.loads(path.read_text(encoding="utf-8"))
        for path in sorted(RESULTS.glob("*.json"))
    }


def publish(score: Path, answered_by: str) -> None:
    """Keep the marks of a set under the next number; once only.

    Args:
        score: a folder that `camtruth blind score` wrote.
        answered_by: the commit whose diagnosis answered.

    Raises:
        InputError: for a set that was made without some source.
    """
    document = json.loads((score / "score.json").read_text(encoding="utf-8"))
    if document["missing_sources"]:
        raise InputError(
            f"a set that was made without {', '.join(document['missing_sources'])}",
            "expected every source: no table is published without",
            "pip install 'camtruth[withheld]', and make the set anew",
        )
    known = sets()
    if any(one["commitment"] == document["commitment"] for one in known.values()):
        return
    rest = ("commitment", "hashes", "cases", "marks")
    kept = {"format": document["format"], "set": document["set"], "answered_by": answered_by}
    kept |= {key: document[key] for key in rest}
    RESULTS.mkdir(parents=True, exist_ok=True)
    with new_file(RESULTS / f"{max(known, default=0) + 1:02}.json") as scratch:
        scratch.write_text(json.dumps(kept, separators=(",", ":")) + "\n", encoding="utf-8")


HEADS = ("set", "its name", "cases", "answered by commit", "nulls called different",
         "catalogue: seen, named right", "other people's code: seen, named right",
         "in no catalogue: called unexplained", "pairs: both found",
         "intervals that hold the strength", "confidently wrong")  # fmt: skip


def set_by_set(known: Mapping[int, Document]) -> str:
    """One line for each set, the newest first."""
    rows = [HEADS, ("---",) * len(HEADS)]
    rows += [_line(number, document) for number, document in sorted(known.items(), reverse=True)]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def _line(number: int, document: Document) -> tuple[str, ...]:
    marks = marks_of(document)

    def of(*groups: str) -> list[Mark]:
        return [m for m in marks if m.group in groups]

    def strong(*groups: str) -> list[Mark]:
        return [m for m in of(*groups) if m.band == "over 4"]

    own, others, strange = strong(*OWN), strong(*OTHERS), strong("strange")
    held = [one for m in of(*OWN) for one in m.covered]
    return (
        str(number),
        document["set"],
        str(len(marks)),
        document["answered_by"],
        _part(m.detected for m in of("null")),
        f"{_part(m.detected for m in own)}, {sum(m.right for m in own)}",
        f"{_part(m.detected for m in others)}, {sum(m.right for m in others)}",
        _part(m.unexplained for m in strange),
        _part(m.found == 2 for m in of("pair")),
        _part(held),
        str(sum(m.wrong for m in marks if m.group != "calibration")),
    )


def _part(hits: Iterable[bool]) -> str:
    found = list(hits)
    return f"{sum(found)} of {len(found)}"


def results(known: Mapping[int, Document]) -> str:
    """The whole table: of the last set, of the last ones together, and of the baselines there."""
    if not known:
        return "No set has been scored for this page yet.\n"
    last = known[max(known)]
    recent = [known[number] for number in sorted(known)[-TOGETHER:]]
    together = f"sets {max(known) - len(recent) + 1} to {max(known)}"
    tables = {
        together: table(_all_marks(recent, "answers")),
        f"set {max(known)} alone": table(marks_of(last)),
        **{f"{who}, {together}": table(_all_marks(recent, who)) for who in BASELINES},
    }
    told = ", ".join(f"{number} {group}" for group, number in last["cases"].items())
    return (
        f"Set {max(known)} has the commitment `{last['commitment']}` and"
        f" {sum(last['cases'].values())} cases ({told}). Limits are bands of severity; each figure"
        " is hits of cases, share, and its 95 % interval. Each set was answered by the code of its"
        f" day, so that sets together are of {len(recent)} commits.\n\n{markdown(tables)}"
    )


def _all_marks(documents: Sequence[Document], who: str) -> list[Mark]:
    return [one for d in documents if who in d["marks"] for one in marks_of(d, who)]


def page() -> str:
    """The whole page."""
    known = sets()
    parts = {"sets": set_by_set(known), "results": results(known)}
    text = TEXT.read_text(encoding="utf-8")
    for name, words in parts.items():
        text = text.replace(f"<!-- {name} -->", words)
    return text


def write_withheld_page() -> None:
    """Write the page anew."""
    with new_file(PAGE) as scratch:
        scratch.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        try:
            publish(Path(sys.argv[1]), sys.argv[2])
        except InputError as refused:
            sys.exit(f"docs: error: {refused}")
    write_withheld_page()
