"""Bias, RMS error and coverage from pairs of truth and estimate."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from analysis.parameters import CannotTell, Estimate, NoiseParameters
from analysis.round_trip import document, round_trip

LIMIT = 4.5


def found(value, se=1.0, key="read", method="mine"):
    finding = CannotTell(reason=value) if isinstance(value, str) else None
    finding = finding or Estimate(value=value, se=se, unit="DN")
    return NoiseParameters(method=method, channels={"G": {key: finding}})


def test_gaussian_estimates_have_their_bias_scatter_and_coverage():
    seeds, sigma, bias, truth = 4000, 0.3, 0.1, 2.0
    values = np.random.default_rng(30).normal(truth + bias, sigma, seeds)
    (row,) = round_trip(({"G": {"read": truth}}, found(float(v), se=sigma)) for v in values)
    assert row.bias_se == pytest.approx(sigma / math.sqrt(seeds), rel=0.06)
    assert abs(row.bias - bias) < LIMIT * row.bias_se
    assert row.estimate == pytest.approx(truth + row.bias)
    assert row.rms == pytest.approx(math.hypot(bias, sigma), rel=0.06)
    share = 0.5 * (
        math.erf((1.96 - bias / sigma) / math.sqrt(2)) + math.erf((1.96 + bias / sigma) / 2**0.5)
    )
    assert abs(row.coverage - share) < LIMIT * math.sqrt(share * (1 - share) / seeds)
    assert (row.seeds, row.answered, row.unit) == (seeds, 1.0, "DN")


def test_what_could_not_be_told_is_counted_and_left_out():
    truth = {"G": {"read": 1.0}}
    rows = round_trip([(truth, found(1.5)), (truth, found("clipped")), (truth, found("clipped"))])
    assert rows[0].answered == pytest.approx(1 / 3)
    assert (rows[0].bias, rows[0].bias_se, rows[0].reason) == (0.5, 1.0, "clipped")


def test_nothing_answered_is_null_not_zero():
    (row,) = round_trip([({"G": {"read": 1.0}}, found("clipped"))])
    told = json.loads(json.dumps(row.to_json()))
    assert [told[key] for key in ("estimate", "bias", "bias_se", "rms", "coverage")] == [None] * 5
    assert (told["truth"], told["answered"], told["unit"]) == (1.0, 0.0, "DN")


def test_truth_may_differ_from_seed_to_seed():
    trips = [({"G": {"read": float(t)}}, found(t + 0.25)) for t in range(1, 6)]
    (row,) = round_trip(trips)
    assert (row.truth, row.bias, row.rms) == pytest.approx((3.0, 0.25, 0.25))


def test_methods_and_parameters_have_rows_of_their_own():
    truth = {"G": {"read": 1.0, "fpn": 2.0}}
    rows = round_trip(
        [
            (truth, found(1.0, method="a")),
            (truth, found(1.1, method="b")),
            (truth, found(2.0, key="fpn", method="a")),
            (truth, found(3.0, key="gain", method="a")),  # no truth, so no row
        ]
    )
    assert [(row.method, row.parameter) for row in rows] == [
        ("a", "read"),
        ("b", "read"),
        ("a", "fpn"),
    ]
    told = document(rows, 1)
    figures = {"truth", "estimate", "bias", "bias_se", "rms", "coverage"}
    keys = {"parameter", "channel", "method", "unit"} | figures
    assert told["format"] == "camtruth-roundtrip/1"
    assert all(keys <= set(row) for row in told["rows"])
