"""How answers of the bench are counted, and the page of it."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import pytest
from scipy import stats

from analysis.gap.verdict.strength import OF_A_SEARCH
from analysis.gap_bench.answers import BANDS, confusion, equivalent, right
from analysis.gap_bench.count import NOMINAL_90, Line, lines, strengths_off
from analysis.gap_bench.page import cells, confusions, limits_table, table
from analysis.gap_bench.published import published
from analysis.gap_bench.share import Share
from docs.gap_page import USUAL_SIZE, gap_page, known
from tests.bench_limits import LIMITS, limit


def row(kind: str, truth: list[str], severity: float, **changed: Any) -> dict[str, Any]:
    plain = {
        "kind": kind,
        "truth": truth,
        "severity": severity,
        "verdict": "explained" if truth else "matched",
        "named": [
            {
                "name": name,
                "probability": 0.9,
                "alike": [],
                "parameters": {"sigma_e": [2.1, 0.1]},
            }
            for name in truth
        ],
        "parameters": {name: {"sigma_e": 2.0} for name in truth},
        "shrink": 0.99,
        "at_floor": False,
    }
    return plain | changed


def named(name: str, *alike: str, probability: float = 0.9) -> dict[str, Any]:
    return {"name": name, "probability": probability, "alike": list(alike), "parameters": {}}


def line(found: list[Line], what: str) -> Line:
    (one,) = [entry for entry in found if entry.what == what]
    return one


def test_errors_of_a_search_are_as_much_larger_as_published_strengths_ask() -> None:
    """They were reported with the errors of fits up to seed 45."""
    off = []
    for seed in range(36, 46):
        run = json.loads(published(USUAL_SIZE, seed).read_text(encoding="utf-8"))
        rows = [one for one in run["rows"] if "skipped" not in one and one["kind"] == "effect"]
        kept = [one for one in rows if right(one) and not equivalent(one, known(run))]
        off += [one.in_errors for one in strengths_off(kept)]
    held = [sum(z <= times * NOMINAL_90 for z in off) for times in (1.0, OF_A_SEARCH)]
    assert (len(off), held) == (93, [79, 84])
    assert abs(held[1] / len(off) - 0.9) < abs(held[0] / len(off) - 0.9)


def test_wilson_interval_has_its_closed_form() -> None:
    """Its ends p solve (share - p)^2 = z^2 p (1 - p) / n."""
    for hits, cases in ((0, 10), (5, 10), (399, 400)):
        found = Share(hits=hits, cases=cases)
        for end in found.interval:
            if 0 < end < 1:
                off = (hits / cases - end) ** 2
                assert off == pytest.approx(
                    stats.norm.ppf(0.975) ** 2 * end * (1 - end) / cases, rel=1e-9
                )
    assert Share(hits=0, cases=0).interval == (0.0, 1.0)


def test_a_diagnosis_that_is_always_right_reaches_every_target() -> None:
    rows = [row("null", [], 0.0, p_unfitted=1e-9) for _ in range(400)]
    for severity in (1.0, 2.0, 4.0, 8.0):
        rows += [row("effect", ["row_noise"], severity) for _ in range(10)]
    rows += [row("withheld", ["row_noise"], s, named=[], verdict="unexplained") for s in (2.0, 4.0)]
    rows += [row("pair", ["row_noise", "gamma"], 4.0) for _ in range(10)]
    # 36 of 40 intervals cover: the truth is 2.0, one standard error off but for these
    for one in rows[400:404]:
        one["named"][0]["parameters"] = {"sigma_e": [2.3, 0.1]}
    found = lines(rows, LIMITS)
    assert [one.what for one in found if one.met is False] == []
    assert sum(one.met is True for one in found) >= 18
    covered = line(found, "severity: 90 % interval covers").found
    assert isinstance(covered, Share)
    assert (covered.hits, covered.cases) == (36, 40)
    assert line(found, "severity: median error").found == (pytest.approx(0.05), 40)


def test_what_is_wrong_is_counted_as_wrong() -> None:
    rows = [
        row("null", [], 0.0, verdict="unexplained"),
        row("null", [], 0.0),
        row("effect", ["gamma"], 1.0, verdict="matched", named=[]),
        row("effect", ["gamma"], 2.0, named=[named("jpeg", "gamma")]),
        row("effect", ["gamma"], 2.0, named=[named("jpeg")]),
        row("effect", ["gamma"], 2.0, named=[named("jpeg", probability=0.4)]),
        row("effect", ["gamma"], 8.0, verdict="unexplained", named=[]),
        row("withheld", ["gamma"], 4.0, named=[named("jpeg")]),
        row("pair", ["gamma", "jpeg"], 4.0, named=[named("smear", "jpeg")]),
        row("effect", ["smear"], 4.0) | {"skipped": "cannot be"},
    ]
    found = lines(rows, LIMITS)

    def share(what: str) -> tuple[int, int]:
        one = line(found, what).found
        assert isinstance(one, Share)
        return one.hits, one.cases

    assert share("false alarms on nulls (nominal 5 %)") == (1, 2)
    assert share("detected, 1 to 2 limits") == (0, 1)
    assert share("right effect, of those detected, 2 to 4 limits") == (0, 3)
    assert share("right class, of those detected, 2 to 4 limits") == (1, 3)
    assert share("right effect, of those detected, over 4 limits") == (0, 1)
    assert share("confidently wrong, effect in the catalogue, 2 to 4 limits") == (1, 3)
    assert share("confidently wrong, effect withheld, over 4 limits") == (1, 1)
    assert share("withheld effect called unexplained, over 4 limits") == (0, 1)
    assert share("pairs: at least one") == (1, 1)
    assert share("pairs: both") == (0, 1)
    assert line(found, "shrink after the right effect, over 4 limits, median").found is None
    wrong = confusion(rows)["gamma", "2 to 4"]
    assert wrong == {"in class": 1, "jpeg": 2}
    assert "in class 1, jpeg 2" not in table(found)
    assert "jpeg 2" in confusions(rows)
    assert cells(line(found, "detected, 1 to 2 limits"))[-1] == "too few cases"
    missed = Line(what="x", found=Share(hits=1, cases=30), met=False)
    assert cells(missed)[-1] == "**not reached**"


def test_what_calibration_takes_up_is_not_expected_to_be_named() -> None:
    taken = LIMITS | {"white_balance": limit("white_balance", absorbed=0.99)}
    rows = [
        row("effect", ["white_balance"], 4.0, verdict="matched", named=[]),
        row("effect", ["white_balance"], 4.0, named=[named("gamma")]),
        row("pair", ["white_balance", "gamma"], 4.0, named=[named("gamma")]),
        row("pair", ["jpeg", "gamma"], 4.0, named=[named("gamma"), named("jpeg")]),
    ]
    found = lines(rows, taken)
    own = line(found, "effects that calibration takes up: matched, or themselves").found
    assert own == Share(hits=1, cases=2)
    assert line(found, "pairs: both").found == Share(hits=1, cases=2)
    neither = line(found, "pairs: both, where calibration takes up neither").found
    assert neither == Share(hits=1, cases=1)
    assert line(found, "detected, over 4 limits").found == Share(hits=0, cases=0)
    assert "calibration-equivalent" in limits_table(taken)


def test_the_bands_touch() -> None:
    assert [low for _, low, _ in BANDS[1:]] == [high for _, _, high in BANDS[:-1]]


def test_the_page_holds_what_was_measured_and_nothing_else() -> None:
    none = gap_page([])
    assert none.count("Not measured yet") == 3
    assert "<!--" not in none
    found = {
        "date": "2000-01-01",
        "commit": "abc",
        "diagnosis": "123",
        "size": "160x120x24",
        "seed": 3,
        "planned": 7,
        "limits": {name: dataclasses.asdict(entry) for name, entry in LIMITS.items()},
        "rows": [row("null", [], 0.0), row("null", [], 0.0, verdict="unexplained")],
    }
    text = gap_page([found])
    assert "2 cases" in text
    assert "| 50 % | 9 to 91 % | 2 |" in text
    assert "commit abc" in text
    assert "| row_noise |" in text
    # the newest stands alone, all of its size stand together
    gamma = row("effect", ["gamma"], 5.0, named=[named("gamma", probability=0.8)])
    later = found | {"date": "2000-01-02", "commit": "def", "seed": 4, "rows": [gamma]}
    larger = found | {"size": "640x480x24", "commit": "ghi"}
    both = gap_page([later, larger, found])
    assert both.index("commit def") < both.index("commit ghi")
    assert "commit abc" not in both
    assert "3 cases of the seeds 3 by abc, 4 by def" in both
    assert "| 0.7 to 0.9 | 80 % | 100 % | 21 to 100 % | 1 |" in both
