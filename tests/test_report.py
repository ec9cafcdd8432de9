"""The report page: whole, alone, and saying what the figures say."""

from __future__ import annotations

import html.parser
import json
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from camtruth.command import main
from camtruth.report.plot import Axis, Marks, axis_over, plot
from tests.conftest import Small

VOID = {"meta", "link", "img", "br", "hr", "input"}


@pytest.fixture(scope="module")
def demo(small: Small, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The demo on a small camera with few light paths."""
    folder = tmp_path_factory.mktemp("demo") / "made"
    words = ["demo", "--camera", str(small.camera), "--protocol", str(small.protocol)]
    words += ["--samples", "8", "--seeds", "2", "--seed", "5", "--out", str(folder)]
    assert main(words) == 0
    return folder


@pytest.fixture(scope="module")
def page(demo: Path) -> str:
    return (demo / "report.html").read_text(encoding="utf-8")


def test_it_needs_no_network(page: str) -> None:
    for attribute in ("src", "href"):
        for target in re.findall(rf'\b{attribute}="([^"]*)"', page):
            assert target.startswith("data:image/png;base64,"), target[:80]
    assert not re.search(r"url\(|@import|<script|https?:", page)


def test_it_is_well_formed(page: str) -> None:
    class Balance(html.parser.HTMLParser):
        def __init__(self) -> None:
            super().__init__()
            self.open: list[str] = []

        def handle_starttag(self, tag: str, attrs: object) -> None:
            if tag not in VOID:
                self.open.append(tag)

        def handle_startendtag(self, tag: str, attrs: object) -> None:
            pass

        def handle_endtag(self, tag: str) -> None:
            assert self.open.pop() == tag

    reader = Balance()
    reader.feed(page)
    assert reader.open == []


def test_it_shows_light_frames_and_curves(page: str) -> None:
    assert page.count("<image ") == 1, "one rendered image for the lamp of the protocol"
    assert page.count("<img ") == 2 + 3, "a lit frame, a dark one, and a panel taken apart"
    assert page.count('<svg class="plot"') == 3 * 3, "Figs. 4 to 6 for R, G and B"
    assert page.count('class="line truth"') == 9 + 1, "truth in every one, and in the legend"


def test_it_says_how_to_make_it_again(page: str, small: Small) -> None:
    (line,) = re.findall(r'<pre class="command">(.*?)</pre>', page)
    for word in (f"--camera {small.camera}", "--samples 8", "--seeds 2", "--seed 5"):
        assert word in line


def test_its_figures_are_those_of_the_files(demo: Path, page: str) -> None:
    document = json.loads((demo / "roundtrip.json").read_text(encoding="utf-8"))
    assert document["seeds"] == 2
    read = next(row for row in document["rows"] if row["parameter"] == "read")
    decimals = max(0, 1 - math.floor(math.log10(read["bias_se"])))
    assert f">{read['bias']:.{decimals}f}<" in page
    truth = json.loads((demo / "capture/truth.json").read_text(encoding="utf-8"))
    for name, version in truth["versions"].items():
        assert f"{name} {version}" in page
    for effect in truth["effects"]:
        assert f"<th>{effect['name']}</th>" in page


def test_the_same_seed_gives_the_same_page(demo: Path, small: Small, tmp_path: Path) -> None:
    words = ["demo", "--camera", str(small.camera), "--protocol", str(small.protocol)]
    words += ["--samples", "8", "--seeds", "2", "--seed", "5", "--out", str(tmp_path / "again")]
    assert main(words) == 0
    for name in ("noise.json", "roundtrip.json"):
        assert (tmp_path / "again" / name).read_bytes() == (demo / name).read_bytes()


def test_a_plot_puts_points_where_they_belong() -> None:
    """Equal steps in the data are equal steps on the page, upwards."""
    axis = Axis(low=0, high=10, label="")
    drawing = ElementTree.fromstring(
        plot("t", axis, axis, [Marks(x=[0, 5, 10], y=[0, 5, 10], style="r")])
    )
    circles = [(float(c.get("cx", "")), float(c.get("cy", ""))) for c in drawing.iter("circle")]
    (x0, y0), (x1, y1), (x2, y2) = circles
    assert x1 - x0 == pytest.approx(x2 - x1, abs=0.11)
    assert y0 - y1 == pytest.approx(y1 - y2, abs=0.11)
    assert y0 > y2


@pytest.mark.parametrize("values", [[0.0], [3.0, 3.0], [-1.0, 2.0], [1e-6, 2e-6], [1e5], []])
def test_an_axis_holds_its_values_and_has_ticks(values: list[float]) -> None:
    axis = axis_over(values, "")
    assert all(axis.low <= value <= axis.high for value in [*values, 0.0])
    assert 2 <= len(axis.ticks()) <= 9
    assert all(axis.low - 1e-9 <= tick <= axis.high + 1e-9 for tick in axis.ticks())
