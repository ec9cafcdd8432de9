"""The study: closed forms that simulated cells follow, a run that goes on, findings."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy import stats

from analysis.study.bench import PRNU, bench
from analysis.study.cell import Plan, run_case
from analysis.study.design import NOISE_STEPS, Case, cases
from analysis.study.findings import bits_for, findings, guidance, least_noise
from analysis.study.prediction import predict
from analysis.study.run import METHODS
from analysis.study.table import COLUMNS, read_parquet, write_parquet
from tests.harness import SIGNIFICANCE

BODIES = 6


def case(**changed: object) -> Case:
    whole = {
        "place": "paper",
        "lamp": "incandescent",
        "bits": 8,
        "electrons_per_dn8": 20.0,
        "noise_steps": 0.5,
        "blur_px": 0.0,
    }
    return Case(**(whole | changed))  # type: ignore[arg-type]


def test_every_combination_is_a_case_once():
    every = cases()
    assert len(every) == 5 * 2 * 3 * 3 * 6 * 2
    assert len(set(every.values())) == len(every)


@pytest.mark.parametrize(
    "changed",
    [
        {"noise_steps": 0.2, "place": "even", "electrons_per_dn8": 66.0},
        {"noise_steps": 1.0, "place": "near", "bits": 12},
        {"noise_steps": 0.35, "place": "close", "bits": 10, "lamp": "fluorescent", "blur_px": 6.0},
    ],
)
def test_simulated_bias_is_the_predicted_one(changed):
    """Student's limit for six bodies, plus 1 % of the truth for what panels leave out of it."""
    rows = run_case(Plan(bodies=BODIES, methods=METHODS), case(**changed))
    assert all(set(row) == set(COLUMNS) for row in rows)
    both = [r for r in rows if r["bias"] is not None and r["predicted_bias"] is not None]
    assert len(both) > 0.6 * len(rows)
    limit = float(stats.t.isf(SIGNIFICANCE / len(both) / 2, BODIES - 1))
    for row in both:
        if row["parameter"] == "prnu" and row["method"] == "irie":
            continue  # an unweighted line whose points' SDs have a bias of their own
        room = limit * row["bias_se"] + 0.01 * row["truth"]
        assert abs(row["bias"] - row["predicted_bias"]) <= room, row


def test_a_ramp_that_nobody_takes_off_is_prnu_of_its_twelfth():
    made = bench(case(place="near", noise_steps=2.0))
    rise = made.rise_dn8["G"] / 123.0
    found = predict(made, "G")["photon_transfer"]["prnu"]
    # The plane is all but a few percent of this light's shading.
    assert found == pytest.approx(np.hypot(PRNU, rise / 12**0.5), rel=0.05)
    assert predict(made, "G")["emva1288"]["prnu"] == pytest.approx(PRNU, rel=0.01)


def rows_with(bias_by_noise: dict[float, float | None]) -> list[dict[str, object]]:
    return [
        {
            "noise_steps": noise,
            "bias": bias,
            "truth": 1.0,
            "bias_se": 0.001,
            "answered": 0.0 if bias is None else 1.0,
        }
        for noise, bias in bias_by_noise.items()
    ]


def test_the_least_noise_is_right_there_and_everywhere_above():
    good = dict.fromkeys(NOISE_STEPS, 0.001)
    assert least_noise(rows_with(good)) == NOISE_STEPS[0]
    assert least_noise(rows_with(good | {0.35: 0.5})) == 0.5
    assert least_noise(rows_with(good | {0.35: None})) == 0.5
    assert least_noise(rows_with(good | {2.0: 0.5})) is None


def test_bits_bring_a_noise_to_so_many_steps():
    assert bits_for(0.35, 0.35) == 8
    assert bits_for(0.5, 0.35) == 10
    assert bits_for(2.0, 0.1) is None
    assert bits_for(None, 1.0) is None


def test_parquet_gives_back_what_was_written(tmp_path):
    rows = run_case(Plan(bodies=2, methods=("photon_transfer",)), case())
    write_parquet(tmp_path / "a.parquet", rows)
    assert read_parquet(tmp_path / "a.parquet") == [{k: r[k] for k in COLUMNS} for r in rows]
    assert any("1 %" in sentence for sentence in findings(rows))
    assert guidance(rows) == []  # a single cell of its gradient and lamp


def test_guidance_is_for_whole_gradients_and_lamps():
    of_place = {
        key: case
        for key, case in cases().items()
        if case.place == "even" and case.lamp == "fluorescent" and case.blur_px == 0
    }
    rows = [
        {
            **{name: getattr(case, name) for name in ("place", "lamp", "bits", "noise_steps")},
            "electrons_per_dn8": case.electrons_per_dn8,
            "channel": channel,
            "method": "mine",
            "parameter": parameter,
            "truth": 1.0,
            "bias": 0.5 if case.noise_steps < 0.5 else 0.001,
            "bias_se": 0.001,
            "scatter": 0.02,
            "answered": 1.0,
            "rise_dn8": 2.0,
            "level_dn8": 100.0,
        }
        for case in of_place.values()
        for channel in "RGB"
        for parameter in ("read", "gain", "fpn", "prnu")
    ]
    (found,) = guidance(rows)
    assert found["least_noise_steps"] == dict.fromkeys(("read", "gain", "fpn", "prnu"), 0.5)
    assert found["frames"] == dict.fromkeys(("4", "20", "66"), 400)  # (2 % / 1 %)^2 of 100
    assert guidance(rows[12:]) == []


def test_the_command_writes_page_and_table_and_goes_on(run, tmp_path):
    words = ["study", "gradient-quantization", "--cells", "3", "--seeds", "2", "--out", "s"]
    words += ["--method", "photon_transfer", "--method", "emva1288"]
    found = json.loads(run(*words, "--json").out)
    assert found["format"] == "camtruth-study/1"
    assert found["cells"] == 3
    assert found["rows"] == 3 * 3 * 2 * 4
    assert all(sentence.endswith(".") for sentence in found["findings"])
    page = (tmp_path / "s" / "study.html").read_text(encoding="utf-8")
    assert found["findings"][0][:30] in page
    assert page.count("Plotly.newPlot") >= 2
    assert "not empty" in run(*words).complaint
    before = (tmp_path / "s" / "results.jsonl").read_bytes()
    again = json.loads(run(*words, "--json", "--resume").out)
    assert again == found
    assert (tmp_path / "s" / "results.jsonl").read_bytes() == before
    assert "another question" in run(*words[:4], "--seeds", 3, "--out", "s", "--resume").complaint
