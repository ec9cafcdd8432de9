"""The bench of the diagnosis: its cases, its limits, its counts, with a diagnosis that is told."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from analysis.gap.diagnose import Diagnosis
from analysis.gap.report import NO_GAP, Figure, GapReport, Named
from analysis.gap_bench.cases import NULLS, PAIRS, Case, all_cases, suspects
from analysis.gap_bench.count import lines
from analysis.gap_bench.draw import (
    ARITHMETICS,
    IN_SIXTEENTHS,
    camera_of,
    capture_of,
    random_camera,
)
from analysis.gap_bench.examine import Bench, examine, unfitted
from analysis.gap_bench.published import document, go_on
from analysis.gap_bench.run import (
    Place,
    code,
    latest,
    light,
    read_limits,
    read_results,
    run_bench,
    write_limits,
)
from analysis.gap_bench.severity import limits_of
from analysis.gap_bench.share import Share
from analysis.identifiability.limits import (
    default_of,
)
from foundation.errors import InputError
from render.rate import RateHeader, RateImage, write_rate
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.demosaic import Demosaic
from sensor.effects.temporal_filter import TemporalFilter
from sensor.effects.white_balance import WhiteBalance
from tests.bench_limits import LIMITS, limit

WIDTH, HEIGHT = 64, 48


def test_cases_are_all_there_once_and_any_beginning_is_a_fair_sample() -> None:
    every = list(all_cases().values())
    assert list(all_cases()) == [case.key for case in every]
    assert len({case.number for case in every}) == len(every)
    others = all_cases(bench_seed=1)
    assert list(others) != [case.key for case in every]
    assert not {case.number for case in every} & {case.number for case in others.values()}
    kinds = [case.kind for case in every]
    assert kinds.count("null") == NULLS
    assert kinds.count("pair") == PAIRS
    for name in suspects():
        assert sum(case.effects == (name,) for case in every) == 4 * 5 + 3 * 2
    start = kinds[:200]
    for kind in ("null", "effect", "withheld", "pair"):
        share = kinds.count(kind) / len(kinds)
        # 4.5 standard errors: 1e-5 for four kinds
        assert abs(start.count(kind) - 200 * share) < 4.5 * np.sqrt(200 * share * (1 - share))


def test_strengths_of_a_band_are_as_likely_by_their_logarithm() -> None:
    """Kolmogorov and Smirnov's test of the octave of each case, at 1 in 10^5."""
    of_effects = [case for case in all_cases().values() if case.kind in ("effect", "withheld")]
    octaves = [np.log2(case.strength / case.severity) for case in of_effects]
    assert stats.kstest(octaves, "uniform").pvalue > 1e-5
    pair = next(case for case in all_cases().values() if case.kind == "pair")
    assert pair.strength == pair.severity


COUNT = ("demosaic", "quantization")
"""How a camera counts is drawn of a few ways, and may be the same twice."""


def test_every_base_figure_is_drawn_anew() -> None:
    first, second = random_camera(1, 48, 64), random_camera(2, 48, 64)
    assert first == random_camera(1, 48, 64)
    for effect in first.effects:
        other = second.get(type(effect))
        assert not effect.values() or effect != other or effect.name in COUNT
    cameras = [random_camera(k, 48, 64) for k in range(60)]
    fills = [camera.get(Demosaic).arithmetic for camera in cameras]
    assert set(fills) == {*range(ARITHMETICS), *IN_SIXTEENTHS}
    balanced = [camera.get(WhiteBalance) is not None for camera in cameras]
    assert balanced == [fill in IN_SIXTEENTHS for fill in fills]
    for field in ("gain_dn_per_e", "black_dn", "sensitivity"):
        assert getattr(first, field) != getattr(second, field)


@pytest.fixture
def place(tmp_path: Path) -> Place:
    """A bench whose light and limits are there already."""
    made = Place(out=tmp_path / "bench", width=WIDTH, height=HEIGHT, frames=16)
    folder = made.out / f"light-{WIDTH}x{HEIGHT}"
    folder.mkdir(parents=True)
    for lamp in ("incandescent", "fluorescent"):
        rate = np.full((HEIGHT, WIDTH, 3), 2e5, dtype=np.float32)
        rate[:, WIDTH // 2 :] *= 0.3
        image = RateImage(
            rate_e_per_s=rate,
            variance=np.zeros_like(rate),
            header=RateHeader(scene="chart", lamp=lamp),
        )
        write_rate(folder / f"rate-{lamp}.exr", image)
    write_limits(made, LIMITS)
    return made


def test_a_run_that_was_stopped_goes_on(place: Place) -> None:
    asked: list[int] = []

    def told(capture: Any, *, stated: Any, suspects: Any) -> Diagnosis:
        asked.append(len(capture.frames))
        assert "row_noise" in {kind.name for kind in suspects}
        gamma = Named(
            name="gamma",
            probability=0.7,
            indistinguishable_from=(),
            absorbed=0.1,
            parameters={"exponent": Figure(value=0.9, se=0.01, unit="1")},
        )
        report = GapReport(verdict="explained", effects=(gamma,), gap=NO_GAP)
        return Diagnosis(report=report, setting=None)

    def go(count: int, case: str | None = None) -> list[dict[str, Any]]:
        return run_bench(
            place,
            count=count,
            kind="null",
            case=case,
            unfitted=False,
            say=lambda _: None,
            diagnosis=told,
        )

    assert len(go(1)) == 1
    with pytest.raises(InputError, match="no case 'null::0:1000'"):
        go(1, case="null::0:1000")
    rows = go(2)
    assert asked == [9, 9]
    assert [r["named"][0]["name"] for r in rows] == ["gamma", "gamma"]
    assert read_results(place.results) == rows
    assert latest(place) == place.results
    assert code() in place.results.name
    assert read_limits(place.limits) == LIMITS
    assert lines(rows, LIMITS)[0].found == Share(hits=2, cases=2)
    assert json.loads(json.dumps(rows)) == rows

    # in another folder, what was published is not done again; of another diagnosis it is
    path = place.out / "published.json"
    found = document(place, rows, place.results.stem)
    path.write_text(json.dumps(found))
    elsewhere = dataclasses.replace(place, out=place.out / "elsewhere")
    assert go_on(elsewhere, path) == 2
    assert read_results(elsewhere.results) == rows
    assert read_limits(elsewhere.limits) == LIMITS
    assert go_on(elsewhere, path) == 0
    path.write_text(json.dumps(found | {"diagnosis": "another"}))
    assert go_on(dataclasses.replace(place, out=place.out / "third"), path) == 0


@pytest.mark.whole
def test_a_camera_that_counts_in_whole_numbers_sees_less_of_a_filter_in_time(place: Place) -> None:
    """Where a demosaicer gives whole numbers, a frame that takes a part a of the one before changes
    no code unless the two differ by 1 / (2 a) of them; where it gives fractions every a shows."""
    images = light(place)
    weakest = {}
    for arithmetic in (0.0, 2.0):
        camera = random_camera(5, HEIGHT, WIDTH).plus(Demosaic(arithmetic=arithmetic))
        (found,) = limits_of(images, 16, camera, [TemporalFilter()]).values()
        assert isinstance(found.parameters["carried"]["value"], float)
        weakest[arithmetic] = found.parameters["carried"]["value"]
    assert weakest[2.0] > 3 * weakest[0.0]
    assert limits_of(images, 16, random_camera(5, HEIGHT, WIDTH), []) == {}


@pytest.mark.whole
def test_light_everywhere_is_what_calibration_means(place: Place) -> None:
    """As much light on every pixel in every shot is a dark current, to the last photon. Along the
    straight directions at the camera without it a strong one has a rest, in the codes above all;
    once the camera is turned and looked at again there is next to none."""
    images = light(place)
    (found,) = limits_of(
        images, 16, random_camera(5, HEIGHT, WIDTH), [default_of(AmbientLight)]
    ).values()
    assert found.absorbed > 0.995


def test_a_case_that_shows_no_scene_and_one_without_its_effect_are_skipped(place: Place) -> None:
    def refused(capture: Any, *, stated: Any, suspects: Any) -> Diagnosis:
        raise InputError("another scene", "expected this one", "state the other")

    images = light(place)
    bench = Bench(light=images, limits=lambda *_: {}, frames=16, diagnosis=refused)
    assert "another scene" in examine(bench, Case(kind="null", seed=1))["skipped"]
    rare = {"value": 1e-9, "unit": "1"}
    none = {"dropped_frames": limit("dropped_frames", parameters={"probability": rare})}
    dropped = Case(kind="effect", effects=("dropped_frames",), severity=1.0)
    found = examine(dataclasses.replace(bench, limits=lambda *_: none), dropped)
    assert "dropped" in found["skipped"]


def test_without_calibration_a_null_is_no_null(place: Place) -> None:
    """Base figures that are known to 2 % are not known well enough, by far."""
    images = light(place)
    case = Case(kind="null", seed=1)
    capture, camera = capture_of(case, camera_of(case, images), (), images, 16)
    assert unfitted(capture, camera, images, case.number) < 1e-6
