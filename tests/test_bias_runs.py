"""The long runs behind the bias page: round trips that go on, causes, and cases that go wrong."""

from __future__ import annotations

import json
import math

import pytest

from analysis.bias import causes, failures
from analysis.bias.coverage import bench, rows, scaled, trip
from analysis.bias.experiment import run_cell
from analysis.bias.setting import Setting
from foundation.jobs import run


def test_round_trips_are_kept_and_become_rows(tmp_path):
    shared = bench("i400", ["photon_transfer", "irie"], raw=True)
    words = {"journal": tmp_path / "a.jsonl", "question": shared.question, "threads": 1}
    first = run(trip, {"0": 0}, shared=shared, **words)
    asked: list[int] = []
    both = run(trip, {"0": 0, "1": 1}, shared=shared, progress=asked.append, **words)
    assert asked == [1, 1]  # the first was known
    assert both["0"] == first["0"]
    found = [scaled(row) for row in rows(shared, list(both.values()))]
    json.dumps(found, allow_nan=False)
    gain = next(r for r in found if r["parameter"] == "gain" and r["channel"] == "G")
    assert gain["seeds"] == 2
    assert abs(gain["bias_of_truth"]) < 0.01
    assert gain["bias_of_truth"] == pytest.approx(gain["bias"] / gain["truth"])
    assert shared.question != bench("i400", ["irie"], raw=True).question


def test_what_a_cause_takes_with_it_is_what_the_closed_form_says():
    cells = {Setting().slug: run_cell(Setting(), range(3), causes.techniques())}
    alone = {name: of for name, of in causes.CAUSES.items() if of.setting.slug in cells}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(causes, "CAUSES", alone)
        found = causes.shares(cells, "R", "fpn")
    for name, (change, se, expected) in found.items():
        assert abs(change - expected) < 30 * se + 0.003, name  # Student's t of 3 bodies
    # A hundredth of 1.6 DN squared beside 0.3 DN: what averaging leaves, with rounding in the way.
    assert 0.02 < found["residual"][0] < 0.05


def test_rounding_twice_adds_noise_and_truncation_moves_the_mean():
    for row in failures.rounding((0.7, 1.5)):
        assert row["once likelihood"] == pytest.approx(row["noise"], rel=0.01)
        assert row["truncated likelihood"] == pytest.approx(row["noise"], rel=0.01)
        assert row["truncated mean"] == pytest.approx(-0.5, abs=0.01)
        assert row["twice plain"] > row["noise"] + 0.02


def test_a_ramp_is_prnu_to_those_who_leave_it_in():
    for row in failures.ramps(range(2)):
        ramp = math.hypot(row["truth"], row["rise"] / math.sqrt(12))
        assert row["read"]["photon_transfer"] == pytest.approx(ramp, rel=0.08)
        assert row["read"]["corrected"] == pytest.approx(row["truth"], rel=0.08)


def test_codes_tell_noise_from_a_quarter_of_a_step_on():
    import numpy as np

    rows_ = failures.tell_map(np.array([0.1, 0.3, 1.0]), np.array([0.0, 2.0]), seeds=2)
    by_place = {(r["noise"], r["black"]): r for r in rows_}
    assert by_place[0.1, 2.0]["told"] == 0
    assert by_place[1.0, 0.0]["told"] == 0  # half of the samples at 0
    for noise in (0.3, 1.0):
        assert by_place[noise, 2.0]["told"] == 1
        assert by_place[noise, 2.0]["ratio"] == pytest.approx(1.0, abs=0.03)
