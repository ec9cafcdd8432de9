"""The bench of the diagnosis: its cases, its limits, its counts, with a diagnosis that is told."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from analysis.gap.diagnose import Diagnosis
from analysis.gap.measure.case import BORROWED, variance_along
from analysis.gap.report import NO_GAP, Figure, GapReport, Named
from analysis.gap_bench.answers import BANDS, confusion
from analysis.gap_bench.cases import NULLS, PAIRS, Case, all_cases, suspects
from analysis.gap_bench.count import Line, lines
from analysis.gap_bench.draw import (
    ARITHMETICS,
    IN_SIXTEENTHS,
    begun,
    camera_of,
    capture_of,
    effects_of,
    random_camera,
)
from analysis.gap_bench.examine import Bench, examine, unfitted
from analysis.gap_bench.page import cells, confusions, limits_table, table
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
from analysis.gap_bench.severity import limits_of, severity_of
from analysis.gap_bench.share import Share
from analysis.identifiability.limits import (
    STANDARD_ERRORS,
    Limit,
    between,
    default_of,
    effect_of,
    error_between,
    limit_of,
)
from docs.gap_page import gap_page
from foundation.errors import InputError
from render.rate import RateHeader, RateImage, write_rate
from sensor.catalogue import catalogue
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.demosaic import Demosaic
from sensor.effects.jpeg import Jpeg
from sensor.effects.row_noise import RowNoise
from sensor.effects.temporal_filter import TemporalFilter
from sensor.effects.white_balance import WhiteBalance

WIDTH, HEIGHT = 64, 48


def limit(name: str, **changed: Any) -> Limit:
    effect = catalogue()[name]()
    parameters = {
        p.name: {"value": getattr(effect, p.name), "unit": p.unit}
        for p in effect.parameters()
        if isinstance(getattr(effect, p.name), (int, float))
    }
    plain = {"z": 5.0, "absorbed": 0.0, "parameters": parameters, "steps": False}
    return Limit(name=name, **(plain | changed))


LIMITS = {name: limit(name) for name in suspects()}


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


def test_strength_follows_the_detection_limit_and_its_range() -> None:
    known = {
        "row_noise": limit("row_noise", parameters={"sigma_e": {"value": 2.0, "unit": "e-"}}),
        "bit_truncation": limit("bit_truncation", steps=True, z=40.0),
    }
    for severity in (1.0, 4.0):
        case = Case(kind="effect", effects=("row_noise",), severity=severity)
        (made,) = effects_of(case, known)
        assert isinstance(made, RowNoise)
        assert made.sigma_e == pytest.approx(2.0 * case.strength)
        assert severity <= case.strength < 2.0 * severity
    strongest = next(p.maximum for p in RowNoise.parameters() if p.name == "sigma_e")
    weak = limit("row_noise", parameters={"sigma_e": {"value": strongest / 2, "unit": "e-"}})
    case = Case(kind="effect", effects=("row_noise",), severity=8.0)
    assert "cannot be" in str(effects_of(case, {"row_noise": weak}))
    assert "not seen" in str(effects_of(case, {"row_noise": limit("row_noise", z=1.0)}))
    whole = Case(kind="effect", effects=("bit_truncation",), severity=1.0)
    assert effects_of(whole, known) == (BitTruncation(bits=2.0),)


def test_what_comes_in_steps_is_drawn_with_all_its_choices() -> None:
    """Of 60 draws of v choices each misses one with a chance of v (1 - 1/v)^60: 6e-6 for 5."""
    algorithms, bits, rows_of_colour = set(), set(), set()
    for seed in range(60):
        names = ("bit_truncation", "chroma_subsampling", "demosaic_other", "row_noise")
        lost, colour, filled, noise = begun(Case(kind="effect", effects=names, seed=seed))
        algorithms.add(filled.values()["algorithm"])
        bits.add(lost.values()["bits"])
        rows_of_colour.add(colour.values()["rows"])
        assert noise == RowNoise()
    assert algorithms == {1.0, 2.0, 3.0, 4.0, 5.0}
    assert bits == {1.0, 2.0, 3.0}
    assert rows_of_colour == {1.0, 2.0}


@pytest.mark.parametrize("power", [1.0, 2.0])
@pytest.mark.parametrize("per_e", [0.02, 30.0])
def test_a_limit_is_where_five_standard_errors_are(power: float, per_e: float) -> None:
    def seen(effect: Any) -> tuple[float, float]:
        z = (per_e * effect.sigma_e) ** power
        return z**2, 2 * z**2

    found = limit_of(RowNoise(), seen)
    assert found.z == pytest.approx(STANDARD_ERRORS, rel=0.06)
    assert found.absorbed == pytest.approx(0.5)
    assert effect_of(found, RowNoise).sigma_e == pytest.approx(  # type: ignore[attr-defined]
        STANDARD_ERRORS ** (1 / power) / per_e, rel=0.06
    )


def test_a_limit_beyond_the_range_and_one_that_comes_in_steps_say_so() -> None:
    assert not limit_of(RowNoise(), lambda effect: (1e-6 * effect.sigma_e, 1.0)).reached
    assert limit_of(BitTruncation(), lambda effect: (900.0, 900.0)).steps


def test_products_of_different_draws_have_no_noise_of_their_own() -> None:
    """Mean of |s|^2 over 400 trials within 4.5 standard errors; the square would have 1000 more."""
    draw = np.random.default_rng(1)
    signal = np.zeros(1000)
    signal[0] = 3.0
    found = [between(signal + draw.standard_normal((4, 1000))) for _ in range(400)]
    assert abs(np.mean(found) - 9.0) < 4.5 * np.std(found) / np.sqrt(len(found))


def test_the_error_of_a_mean_product_is_that_of_its_scatter() -> None:
    """Jackknife against 400 trials, within 4.5 standard errors: 6 draws know it to a third each."""
    draw = np.random.default_rng(2)
    signal = np.zeros(200)
    signal[0] = 8.0
    drawn = [signal + draw.standard_normal((6, 200)) for _ in range(400)]
    scatter = np.std([between(rows) for rows in drawn])
    squares = np.array([error_between(rows) ** 2 for rows in drawn])
    error = np.hypot(squares.std() / np.sqrt(400), scatter**2 * np.sqrt(2 / 400))
    # the jackknife counts the products of two draws' noise twice: a part of 200 / (200 + 4 * 320)
    assert scatter**2 - 4.5 * error < squares.mean() < 1.3 * scatter**2 + 4.5 * error


def test_figures_that_have_something_in_common_tell_less() -> None:
    """Twins that scatter with a variance of 4 along a direction: 200, and 6 that are borrowed."""
    draw = np.random.default_rng(3)
    residuals = draw.standard_normal((200, 2)) * [2.0, 1.0]
    spread: Any = SimpleNamespace(residuals=residuals)
    along, across = (variance_along(spread, np.array(d)) for d in ([3.0, 0.0], [0.0, 3.0]))
    # 4.5 standard errors of a variance of 200
    assert along == pytest.approx((200 * 4 + BORROWED) / (200 + BORROWED), rel=4.5 * 0.1)
    assert 1.0 <= across < 1.0 + 4.5 * 0.1
    assert variance_along(spread, np.zeros(2)) == 1.0


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


@pytest.mark.parametrize("z", [100.0, 1e4])
def test_what_begins_at_a_threshold_is_found_there_and_counts_as_strong(z: float) -> None:
    def seen(effect: Any) -> tuple[float, float]:
        chi2 = z**2 if effect.sigma_e > 7.0 else 0.0
        return chi2, chi2

    found = limit_of(RowNoise(), seen)
    assert effect_of(found, RowNoise).sigma_e == pytest.approx(7.0, rel=0.1)  # type: ignore[attr-defined]
    assert found.z == pytest.approx(z)
    case = Case(kind="effect", effects=("row_noise",), severity=2.0)
    assert severity_of(case, found) == pytest.approx(case.strength * z / STANDARD_ERRORS)
    assert severity_of(case, limit("row_noise", z=5.2)) == case.strength
    assert severity_of(case, limit("row_noise", z=40.0, steps=True)) == 8.0


def test_an_effect_without_a_strength_is_taken_at_its_default() -> None:
    assert default_of(Jpeg) == Jpeg()
