"""Marks and their table follow the words of the gap report's format; the seal stays shut until
every answer is written and hashed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from scipy import stats

from camtruth.blind.errors import BlindError
from camtruth.blind.format import (
    CASES,
    SEAL_FORMAT,
    SET_FORMAT,
    TRUTH,
    CaseEntry,
    CaseTruth,
    SetDocument,
    TrueEffect,
    beside,
    write_set,
)
from camtruth.blind.intervals import CONFIDENCE, difference, of_median, wilson
from camtruth.blind.marks import band_of, mark
from camtruth.blind.scoring import markdown, rows_of, score, tables_of
from camtruth.blind.table import Score, table
from foundation.output import CHECKSUMS, sha256, write_checksums
from foundation.verification import DamageError
from tests.conftest import Run

TRIES = 40
Z = float(stats.norm.ppf((1 + CONFIDENCE) / 2))


def effect(name: str, severity: float = 3.0, **changes: Any) -> TrueEffect:
    told: dict[str, Any] = {
        "name": name,
        "answers": (name,),
        "stage": "readout",
        "source": "own",
        "parameters": {"sigma_e": 10.0},
        "severity": severity,
        "absorbed": 0.0,
    }
    return TrueEffect(**{**told, **changes})


def case(group: str, *effects: TrueEffect, without: tuple[str, ...] = ()) -> CaseTruth:
    return CaseTruth(
        group=group, camera="i400", seed=1, body_seed=2, effects=effects, without=without
    )


def answer(
    verdict: str, *names: str, probability: float = 0.9, alike: tuple[str, ...] = (), **more: Any
) -> dict[str, Any]:
    effects = [
        {
            "name": name,
            "probability": probability,
            "indistinguishable_from": list(alike),
            "parameters": {"sigma_e": {"value": 11.0, "se": 0.5, "unit": "e-"}},
        }
        for name in names
    ]
    return {
        "format": "camtruth-gap/1",
        "verdict": verdict,
        "effects": effects,
        "gap": {"shrink": 0.97, "at_floor": False},
        "where": [{"stage": "readout"}],
        **more,
    }


def test_an_interval_of_nothing_and_of_all_is_wilsons() -> None:
    assert wilson(0, TRIES) == pytest.approx((0.0, Z**2 / (TRIES + Z**2)))
    assert wilson(TRIES, TRIES) == pytest.approx((TRIES / (TRIES + Z**2), 1.0))
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.9])
def test_an_interval_of_a_share_covers_as_often_as_wilsons_does(share: float) -> None:
    """Wilson's coverage swings about 95 %; its published minimum for such shares is above 92 %."""
    chances = stats.binom.pmf(range(TRIES + 1), TRIES, share)
    held = [low <= share <= high for low, high in (wilson(k, TRIES) for k in range(TRIES + 1))]
    assert 0.92 < sum(chances[held]) < 0.99


def test_a_difference_of_equal_shares_is_about_nothing() -> None:
    low, high = difference((30, TRIES), (30, TRIES))
    assert low == pytest.approx(-high)
    assert low < 0 < high


@pytest.mark.parametrize("count", [6, 9, 25, 60])
def test_an_interval_of_a_median_holds_it_in_95_cases_of_100(count: int) -> None:
    """Ranks r and n + 1 - r enclose the median with probability 1 - 2 B(r - 1; n, 1/2)."""
    ends = of_median([float(k) for k in range(1, count + 1)])
    assert ends is not None
    rank = round(ends[0])
    assert ends[1] == count + 1 - rank
    assert 1 - 2 * stats.binom.cdf(rank - 1, count, 0.5) >= 0.95
    assert 1 - 2 * stats.binom.cdf(rank, count, 0.5) < 0.95


def test_five_values_are_too_few_for_an_interval() -> None:
    assert of_median([1.0] * 5) is None
    assert of_median([]) is None


def test_the_name_given_is_right_and_its_class_too() -> None:
    truth = case("own", effect("row_noise"))
    found = mark("a", truth, answer("explained", "row_noise"))
    assert (found.right, found.right_class, found.wrong, found.detected) == (
        True,
        True,
        False,
        True,
    )
    assert found.errors == pytest.approx((0.1,))
    assert found.covered == (False,)  # 11 +- 0.5 at 90 % ends at 10.18
    assert found.shrink == 0.97
    assert found.place is True


def test_a_name_in_the_class_is_right_in_class_and_not_wrong() -> None:
    truth = case("own", effect("row_noise"))
    found = mark("a", truth, answer("explained", "interference", alike=("row_noise",)))
    assert (found.right, found.right_class, found.wrong) == (False, True, False)
    assert found.shrink is None


@pytest.mark.parametrize(("probability", "wrong"), [(0.5, True), (0.49, False)])
def test_another_name_is_confidently_wrong_from_a_half(probability: float, wrong: bool) -> None:
    truth = case("own", effect("row_noise"))
    assert mark("a", truth, answer("explained", "jpeg", probability=probability)).wrong is wrong


def test_any_name_is_wrong_of_an_effect_that_is_in_no_catalogue() -> None:
    truth = case("strange", effect("tearing", answers=(), source="none"))
    assert mark("a", truth, answer("explained", "row_noise")).wrong
    assert mark("a", truth, answer("unexplained")).unexplained


def test_an_effect_that_may_not_be_suspected_has_no_right_name() -> None:
    truth = case("left-out", effect("row_noise"), without=("row_noise",))
    found = mark("a", truth, answer("explained", "row_noise"))
    assert found.wrong
    assert not found.right


def test_a_decoy_is_judged_by_its_own_effect() -> None:
    truth = case("decoy", effect("row_noise"), without=("jpeg",))
    assert mark("a", truth, answer("explained", "row_noise")).right


def test_what_calibration_takes_up_counts_as_nothing_wrong() -> None:
    truth = case("own", effect("white_balance", absorbed=0.95))
    assert mark("a", truth, answer("matched")).group == "calibration"


@pytest.mark.parametrize(
    ("names", "found"),
    [(("row_noise", "jpeg"), 2), (("jpeg",), 1), (("gamma",), 0), ((), 0)],
)
def test_a_pair_is_counted_by_its_effects(names: tuple[str, ...], found: int) -> None:
    truth = case("pair", effect("row_noise"), effect("jpeg"))
    assert mark("a", truth, answer("explained", *names)).found == found


def test_bands_are_of_the_weakest_effect() -> None:
    truth = case("pair", effect("row_noise", 9.0), effect("jpeg", 1.5))
    assert band_of(truth.severity) == "1 to 2"
    assert [band_of(s) for s in (0.0, 1.0, 2.0, 4.0)] == ["below 1", "1 to 2", "2 to 4", "over 4"]


def row(rows: list[Score], figure: str, group: str, band: str = "all") -> Score:
    return next(r for r in rows if (r.figure, r.group, r.band) == (figure, group, band))


def test_the_table_counts_every_kind_of_case_apart() -> None:
    marks = [
        mark("n1", case("null"), answer("matched")),
        mark("n2", case("null"), answer("explained", "jpeg")),
        mark("o1", case("own", effect("row_noise")), answer("explained", "row_noise")),
        mark("o2", case("own", effect("row_noise")), answer("matched")),
        mark("t1", case("others", effect("x", answers=("jpeg",))), answer("explained", "gamma")),
        mark("s1", case("strange", effect("y", answers=())), answer("unexplained")),
        mark("p1", case("pair", effect("jpeg"), effect("gamma")), answer("explained", "jpeg")),
    ]
    rows = table(marks)
    told = {
        ("false alarms", "nothing wrong", "all"): (1, 2),
        ("confidently wrong", "nothing wrong", "below 1"): (1, 2),
        ("detected", "own code", "2 to 4"): (1, 2),
        ("right effect, of those detected", "own code", "2 to 4"): (1, 1),
        ("right class, of those detected", "other people's code", "2 to 4"): (0, 1),
        ("confidently wrong", "other people's code", "2 to 4"): (1, 1),
        ("called unexplained", "in no catalogue", "2 to 4"): (1, 1),
        ("right place, of those", "in no catalogue", "all"): (1, 1),
        ("both found", "pairs", "all"): (0, 1),
        ("one found", "pairs", "all"): (1, 1),
    }
    for (figure, group, band), counted in told.items():
        found = row(rows, figure, group, band)
        assert (found.hits, found.cases) == counted, found
        assert found.low == wilson(*counted)[0]
    apart = row(rows, "right class, other people's code less own code", "both", "1 and over")
    assert apart.value == -1.0
    assert row(rows, "detected", "left out", "over 4").value is None


@pytest.fixture
def made(tmp_path: Path) -> Path:
    """A set of two cases with its seal and no answers; nothing is simulated."""
    folder, names = tmp_path / "set", ("00000000aa", "00000000bb")
    seal = beside(folder, "seal")
    for place in (folder / CASES, seal):
        place.mkdir(parents=True)
    effects = effect("row_noise").__dict__ | {"answers": ["row_noise"]}
    base = {"camera": "i400", "seed": 1, "body_seed": 2}
    document = {
        "format": SEAL_FORMAT,
        "salt": "0" * 64,
        "secret": "1" * 64,
        "seed": 3,
        "cases": {
            names[0]: {"group": "null", **base},
            names[1]: {"group": "own", "effects": [effects], **base},
        },
    }
    (seal / TRUTH).write_text(json.dumps(document))
    cases = tuple(CaseEntry(name=name) for name in names)
    told = SetDocument(format=SET_FORMAT, name="small", commitment=sha256(seal / TRUTH), case=cases)
    write_set(folder, told)
    return folder


def answered(folder: Path, *, hashed: bool = True) -> Path:
    place = beside(folder, "answers")
    place.mkdir()
    (place / "00000000aa.json").write_text(json.dumps(answer("matched")))
    (place / "00000000bb.json").write_text(json.dumps(answer("explained", "row_noise")))
    if hashed:
        write_checksums(place)
    return place


def test_the_seal_is_opened_once_all_is_answered(made: Path) -> None:
    answered(made)
    document = score(made)
    assert document["cases"] == {"null": 1, "own": 1}
    rows = rows_of(document)
    assert row(rows, "right effect, of those detected", "own code", "2 to 4").hits == 1
    assert row(rows, "false alarms", "nothing wrong").hits == 0
    assert "| detected | own code | 2 to 4 |" in markdown(tables_of(document))
    assert math.isfinite(json.loads(json.dumps(document, allow_nan=False))["marks"]["answers"][0][
        "severity"])  # fmt: skip


def test_the_seal_stays_shut_without_hashes(made: Path) -> None:
    answered(made, hashed=False)
    with pytest.raises(BlindError, match=CHECKSUMS):
        score(made)


def test_the_seal_stays_shut_while_a_case_is_not_answered(made: Path) -> None:
    (answered(made) / "00000000aa.json").unlink()
    with pytest.raises(BlindError, match="1 cases without an answer"):
        score(made)


def test_an_answer_may_not_change_after_it_was_hashed(made: Path) -> None:
    (answered(made) / "00000000bb.json").write_text(json.dumps(answer("matched")))
    with pytest.raises(DamageError):
        score(made)


def test_another_truth_than_the_published_one_is_refused(made: Path) -> None:
    answered(made)
    path = beside(made, "seal") / TRUTH
    path.write_text(path.read_text().replace('"seed": 3', '"seed": 4'))
    with pytest.raises(BlindError, match="not the truth that the set was published with"):
        score(made)


def test_the_command_scores_and_shows_others_beside(made: Path, run: Run) -> None:
    place = answered(made)
    told = run("blind", "score", made, "--beside", f"plain={place}", "--json")
    assert told.code == 0, told.err
    assert set(json.loads(told.out)["rows"]) == {"answers", "plain"}
    assert (beside(made, "score") / "table.md").exists()
    assert "not empty" in run("blind", "score", made).complaint


@pytest.mark.parametrize(
    "words",
    [
        ("score", "nowhere"),
        ("solve", "nowhere"),
        ("split", "nowhere"),
        ("make",),
        ("make", "--set", "x", "--cases", "nothing=1"),
        ("make", "--set", "x", "--cases", "null"),
        ("make", "--set", "x", "--cases", "put-back=1"),
        ("make", "--set", "x", "--cases", "null=0"),
        ("make", "--set", "x", "--size", "160"),
        ("make", "--set", "../x"),
        ("make", "--set", "x", "--camera", "none-such"),
        ("make", "--set", "x", "--protocol", "none-such"),
    ],
)
def test_bad_input_is_one_line(words: tuple[str, ...], run: Run) -> None:
    run("blind", *words).complaint  # noqa: B018  it asserts
    assert not Path("camtruth-out").exists()


@pytest.mark.parametrize("solver", ["none-such", "none.py:solve"])
def test_an_unknown_solver_is_refused(solver: str, made: Path, run: Run) -> None:
    assert "expected" in run("blind", "solve", made, "--solver", solver).complaint
