"""The page on withheld effects: its text, and the table of the set that was scored last."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from camtruth.blind.scoring import markdown
from foundation.output import new_file

HERE = Path(__file__).parent
TEXT = HERE / "withheld_text.md"
RESULTS = HERE / "results" / "withheld.json"
PAGE = HERE / "withheld.md"


def results(document: Mapping[str, Any] | None) -> str:
    """What may be published of a score; of a set without some source, nothing."""
    if document is None:
        return "No set has been scored for this page yet.\n"
    if document["missing_sources"]:
        missing = ", ".join(document["missing_sources"])
        return f"The last set was made without {missing}: no table is published from it.\n"
    cases = document["cases"]
    told = ", ".join(f"{number} {group}" for group, number in cases.items())
    return (
        f"Set `{document['set']}`, commitment `{document['commitment']}`: {sum(cases.values())}"
        f" cases ({told}). Limits are bands of severity; each figure is hits of cases, share, and"
        f" its 95 % interval.\n\n{markdown(document)}"
    )


def page() -> str:
    """The whole page."""
    known = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else None
    return TEXT.read_text(encoding="utf-8") + results(known)


def write_withheld_page(score: Path | None = None) -> None:
    """Write the page, with a newly scored set where one is given.

    Args:
        score: a folder that `camtruth blind score` wrote.
    """
    if score is not None:
        document = json.loads((score / "score.json").read_text(encoding="utf-8"))
        RESULTS.parent.mkdir(exist_ok=True)
        with new_file(RESULTS) as scratch:
            scratch.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    with new_file(PAGE) as scratch:
        scratch.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    write_withheld_page(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
