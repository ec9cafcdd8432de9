"""The page of `camtruth reproduce`, made with the docs: camtruth-out/docs/reproduce.html."""

from __future__ import annotations

from pathlib import Path

from analysis.bias.setting import light
from analysis.reproduce.reproduction import reproduce
from camtruth.report.reproduction import page
from scenes.geometry import analysis_panels
from scenes.scene import load as load_scene
from sensor.camera_file import load as load_camera
from sensor.protocol import load as load_protocol

PAGE = Path(__file__).parent.parent / "camtruth-out" / "docs" / "reproduce.html"
SEEDS = 8


def write_reproduction() -> None:
    """The page, in the light of the closed form."""
    made = reproduce(
        load_camera("i400"),
        load_protocol("paper"),
        light(),
        analysis_panels(load_scene("chart")),
        seeds=range(SEEDS),
    )
    PAGE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(made, f"camtruth reproduce --seeds {SEEDS}"), encoding="utf-8")
