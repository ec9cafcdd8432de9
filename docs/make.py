"""Write what the documentation takes from the code and from docs/results/.

    effects.md, figures/effects/                     the catalogue
    bias.md, figures/bias/                           from `make bias`
    decisions/i400-debiased.md                       from `make bias`
    study-gradient-quantization.md, study-noise.svg  from `make study`
    camtruth-out/docs/                               the paper's figures beside ours, and the study
    light.md, figures/light/                         the light
    gap.md                                           from `make bench-gap`
    figures/overview.svg                             README's figure, from the files of a demo

Run by `make docs`, which runs the demo first if there is none. `make withheld` and
`make another-camera` write their own pages.
"""

from __future__ import annotations

import base64
import json
import sys
from pathlib import Path

from camtruth.report.curves import figures
from docs.bias_page import write_bias_page
from docs.debias_page import write_debias_page
from docs.effect_figures import write_figures
from docs.effects_page import catalogue_page
from docs.gap_page import write_gap_page
from docs.light_page import write_light_page
from docs.reproduction_page import write_reproduction
from docs.sheet import marks
from docs.study_page import write_study_page
from foundation.output import new_file
from render.preview import balanced, srgb
from render.rate import read_rate
from sensor.capture_folder import TRUTH, read_capture

HERE = Path(__file__).parent
DEMO = HERE.parent / "camtruth-out" / "demo"


def overview() -> str:
    """Light, a frame, and the noise in green against the truth: one SVG that needs nothing."""
    from camtruth.measuring import measure

    folder = DEMO / "capture"
    capture = read_capture(folder)
    truth = json.loads((folder / TRUTH).read_text(encoding="utf-8"))
    light = balanced(read_rate(folder / "rate-fluorescent.exr"))
    frame = srgb(capture.frames[-1].dn[0] / capture.frames[-1].top_dn)
    total = figures(measure(capture), truth, capture)[2]["svgs"][1]
    texts = (
        (14, "Light, path-traced out of focus"),
        (344, "One frame of the simulated camera"),
        (684, "Noise in green: measured, fitted, true (dashed)"),
    )
    labels = "".join(f'<text class="head" x="{x}" y="22">{text}</text>' for x, text in texts)
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1040 290" width="1040">'
        f"<style>{marks()} svg {{ overflow: visible }}"
        " .head { font: 600 12px system-ui, sans-serif; fill: #1c1e21 }</style>"
        '<rect width="1040" height="290" fill="#fdfdfc"/>'
        f"{labels}"
        f'<image x="14" y="34" width="316" height="237" href="{_jpeg(light)}"/>'
        f'<image x="344" y="34" width="316" height="237" href="{_jpeg(frame)}"/>'
        f'<svg x="674" y="34" width="352" height="248">{total}</svg></svg>\n'
    )


def _jpeg(pixels: object) -> str:
    import io

    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, format="jpeg", quality=88)  # type: ignore[arg-type]
    return "data:image/jpeg;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def main() -> None:
    """Write all of it."""
    if not (DEMO / "capture" / "capture.toml").is_file():
        sys.exit(f"docs: no demo in {DEMO}; expected its files for a figure; run 'make demo'")
    with new_file(HERE / "effects.md") as scratch:
        scratch.write_text(catalogue_page(), encoding="utf-8")
    write_figures(HERE / "figures" / "effects")
    write_bias_page()
    write_debias_page()
    write_study_page()
    write_reproduction()
    write_light_page()
    write_gap_page()
    with new_file(HERE / "figures" / "overview.svg") as scratch:
        scratch.write_text(overview(), encoding="utf-8")


if __name__ == "__main__":
    main()
