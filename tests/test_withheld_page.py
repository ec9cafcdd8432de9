"""The page on withheld effects: written from the scores that are kept, and from nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from docs import withheld_page
from docs.withheld_page import PAGE, page, publish, results, set_by_set, sets
from foundation.errors import InputError


def test_the_page_is_what_the_scores_say() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run 'python -m docs.withheld_page'"


def test_sets_are_numbered_without_a_gap_and_none_is_told_twice() -> None:
    known = sets()
    assert sorted(known) == list(range(1, len(known) + 1))
    assert len({one["commitment"] for one in known.values()}) == len(known)


def test_a_set_is_counted_by_its_marks() -> None:
    line = next(row for row in set_by_set(sets()).splitlines() if row.startswith("| 19 "))
    assert line == (
        "| 19 | nineteenth | 50 | 7845d33 | 1 of 10 | 2 of 4, 2 | 7 of 7, 5 | 5 of 6 | 1 of 3"
        " | 8 of 9 | 1 |"
    )


def test_a_score_is_kept_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    score = {**sets()[19], "rows": {}, "missing_sources": []}
    monkeypatch.setattr(withheld_page, "RESULTS", tmp_path / "kept")
    (tmp_path / "score.json").write_text(json.dumps(score))
    for commit in ("abcdef0", "0fedcba"):
        publish(tmp_path, commit)
    (only,) = sets().items()
    assert only[0] == 1
    assert only[1]["answered_by"] == "abcdef0"
    assert "rows" not in only[1]


def test_nothing_is_published_of_a_set_without_some_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    score = {**sets()[19], "missing_sources": ["pyxel"]}
    monkeypatch.setattr(withheld_page, "RESULTS", tmp_path / "kept")
    (tmp_path / "score.json").write_text(json.dumps(score))
    with pytest.raises(InputError, match="without pyxel"):
        publish(tmp_path, "abcdef0")
    assert results(sets()).startswith("No set")


def test_sets_together_have_the_cases_of_each() -> None:
    known = sets()
    last = sorted(known)[-withheld_page.TOGETHER :]
    nulls = sum(known[number]["cases"]["null"] for number in last)
    row = next(r for r in results(known).splitlines() if r.startswith("| false alarms | nothing"))
    assert f"/{nulls}, " in row.split("|")[5]
