"""What a protocol can tell apart: geometry of signatures, choice of shots, the file."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from click.testing import CliRunner

from analysis.identifiability import known as known_camera
from analysis.identifiability.known import base_of
from analysis.identifiability.recommend import Recommendation, Step, choose, recommend
from analysis.identifiability.shots import candidates, of_the_paper, with_uniform
from analysis.identifiability.subsets import NEEDED, Separability, told
from camtruth.commands.protocol import command, document, pixels, toml
from foundation.errors import InputError
from render.rate import RateHeader, RateImage
from sensor.camera_file import load
from sensor.effects.column_fpn import ColumnFpn
from sensor.effects.row_noise import RowNoise
from sensor.protocol import Protocol, Shot
from sensor.protocol import load as load_protocol


def test_what_is_left_of_one_after_the_best_of_another() -> None:
    """|s|^2 sin^2 of the angle, by hand."""
    angle = np.deg2rad(30)
    rows = np.array([[11.0, 0.0, 0.0], [8 * np.cos(angle), 8 * np.sin(angle), 0.0], [0, 0, 1.0]])
    found = told(rows, ["a", "b", "c"], [True, True, True])
    assert found.apart[0, 1] == pytest.approx(121 * 0.25)
    assert found.apart[1, 0] == pytest.approx(64 * 0.25)
    assert found.apart[0, 2] == pytest.approx(121)
    assert found.seen == pytest.approx([121, 64, 1])
    assert found.separated == ("a",)
    assert found.unseen == ("c",)
    assert found.classes == [["a", "b"]]
    assert found.merit == pytest.approx(1 + 16 / NEEDED + 1 / NEEDED)


def test_an_effect_that_is_only_ever_added_does_not_pass_for_its_opposite() -> None:
    rows = np.array([[10.0, 0.0], [-10.0, 0.1]])
    assert not told(rows, ["a", "b"], [True, True]).separated
    assert told(rows, ["a", "b"], [False, False]).separated == ("a", "b")


class Parts:
    """A prediction in which each shot shows one effect, and one shows two, at 1 each frame."""

    shows: ClassVar = {"dark": {0}, "lit": {1, 2}, "again": {1}, "nothing": set[int]()}

    def told_by(self, labels: Sequence[str], groups: int) -> Separability:
        seen: set[int] = set().union(*(self.shows[label] for label in labels))
        rows = np.diag([2.5 * np.sqrt(groups) * (k in seen) for k in range(3)])
        return told(rows, ["a", "b", "c"], [True] * 3)


def test_the_shots_that_help_most_come_first_and_no_frame_is_spent_for_nothing() -> None:
    front, best, found = choose(Parts(), list(Parts.shows))  # type: ignore[arg-type]
    assert best.shots == ("lit", "dark")
    # chi-squared 6.25 a group: 25 takes four
    assert best.frames == 32
    assert found.separated == ("a", "b", "c")
    assert [step.separated for step in front] == [0, 2, 3]
    assert all(a.total < b.total for a, b in itertools.pairwise(front))
    _, less, _ = choose(Parts(), list(Parts.shows), most_frames=40)  # type: ignore[arg-type]
    assert less.total == 32
    assert less.separated == 2


def test_shots_are_darks_lamps_and_an_even_field() -> None:
    lamps = ("incandescent", "fluorescent")
    shots = candidates(lamps)
    labels = [shot.label for shot in shots]
    assert len(set(labels)) == len(labels) == 3 + 3 * 4
    assert set(of_the_paper(lamps)) <= set(labels)
    rates = with_uniform({"incandescent": np.arange(48, dtype=np.float32).reshape(4, 4, 3)})
    assert np.ptp(rates["uniform"], axis=(0, 1)).max() == 0


def test_a_camera_that_is_known_needs_no_calibration() -> None:
    """Figures of the preset in DN: read noise is the square sum of its three parts."""
    base = base_of(load("icx098"), ["a"])
    gain = load("icx098").gain_dn_per_e.G
    assert base.read_dn2[1] == pytest.approx(gain**2 * (8.0**2 + 14.0**2 + 5.0**2))
    assert base.fpn_dn2[1] == pytest.approx((gain * 10.0) ** 2)
    assert base.prnu2[1] == pytest.approx(0.01**2)
    assert base.dark_e_per_s == 60.0


def a_recommendation() -> Recommendation:
    rows = np.array([[10.0, 0.0, 0.0], [10.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    shots = (
        Shot(label="dark-8ms", exposure_s=0.008, frames=16, interval_s=0.1),
        Shot(label="u", light=("uniform",), level=(0.5,), exposure_s=0.03, frames=16),
    )
    step = Step(shots=("dark-8ms", "u"), frames=16, separated=0)
    return Recommendation(
        protocol=Protocol(name="recommended-x", shot=shots),
        told=told(rows, ["row_noise", "gamma", "smear", "jpeg"], [True] * 4),
        front=(step,),
        reference=step,
    )


def test_the_file_is_a_protocol_and_says_what_it_cannot_tell(tmp_path: Path) -> None:
    found = a_recommendation()
    text = toml(found, "i400", "chart", 0.1)
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    assert load_protocol(str(file)) == found.protocol
    assert "# Confused: row_noise, gamma." in text
    assert "# Not seen: smear, jpeg." in text
    data = json.loads(json.dumps(document(found, "chart", 0.1), allow_nan=False))
    assert data["frames"] == 32
    assert data["confused"] == [["row_noise", "gamma"]]


@pytest.mark.parametrize("size", ["160", "160x", "x120", "axb", "161x120", "32x32", "9999x120"])
def test_sizes_that_cannot_be_are_refused(size: str) -> None:
    with pytest.raises(InputError, match="size"):
        pixels(size)
    assert pixels("160x120") == (160, 120)


def flat(scene: str, width: int, height: int, samples: int) -> dict[str, RateImage]:
    rate = np.full((height, width, 3), 1.5e5, dtype=np.float32)
    rate[:, width // 2 :] *= 0.3
    return {
        lamp: RateImage(
            rate_e_per_s=rate,
            variance=np.zeros_like(rate),
            header=RateHeader(scene=scene, lamp=lamp),
        )
        for lamp in ("first", "second")
    }


def test_two_patterns_in_the_dark_are_separated_by_darks_alone() -> None:
    """Rows that move and columns that stay differ wherever they are strong enough."""
    light = flat("none", 64, 64, 1)
    found = recommend(load("icx098"), light, strength=1.0, kinds=[RowNoise, ColumnFpn])
    assert set(found.told.separated) == {"row_noise", "column_fpn"}
    assert found.front[-1].total == 16
    (shot,) = found.protocol.shot
    assert shot.dark
    assert found.reference is not None
    assert found.reference.separated == 2


def test_the_command_writes_what_it_found(tmp_path: Path, monkeypatch: Any) -> None:
    asked: dict[str, Any] = {}

    def told_so(camera: Any, light: Any, **wanted: Any) -> Recommendation:
        asked.update(wanted, size=next(iter(light.values())).rate_e_per_s.shape)
        return a_recommendation()

    monkeypatch.setattr(known_camera, "small_light", flat)
    monkeypatch.setattr("analysis.identifiability.recommend.recommend", told_so)
    out = tmp_path / "p.toml"
    words = ["recommend", "--size", "96x64", "--frames", "100", "--json", "--out", str(out)]
    said = CliRunner().invoke(command, words, catch_exceptions=False)
    assert said.exit_code == 0
    assert json.loads(said.stdout)["paper"]["frames"] == 32
    assert asked["size"] == (64, 96, 3)
    assert asked["most_frames"] == 100
    assert load_protocol(str(out)).name == "recommended-x"
    with pytest.raises(InputError, match="is there already"):
        CliRunner().invoke(command, words, catch_exceptions=False)
