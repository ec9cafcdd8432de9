"""docs/study-gradient-quantization.md, and the page to explore, from the study's table."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from analysis.study.design import NOISE_STEPS
from analysis.study.findings import KEYS, WORDS, document, relative, select
from analysis.study.table import read_parquet
from camtruth.report.plot import Axis, Marks, axis_over, plot
from camtruth.report.study import GUIDANCE, bits_table, frames_table, page
from docs.sheet import sheet

HERE = Path(__file__).parent
TABLE = HERE / "results" / "gradient-quantization.parquet"
PAGE = HERE.parent / "camtruth-out" / "docs" / "study.html"
COMMAND = "camtruth study gradient-quantization --seeds 4"
STYLES = {"irie": "k", "emva1288": "b", "photon_transfer": "r", "corrected": "g"}


def write_study_page(seeds: int = 4) -> None:
    """Both pages."""
    rows = read_parquet(TABLE)
    found = document(rows, seeds)
    PAGE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(rows, found, COMMAND), encoding="utf-8")
    (HERE / "figures" / "study-noise.svg").write_text(_figure(rows), encoding="utf-8")
    parts = [
        HEAD.format(cells=found["cells"], seeds=seeds, command=COMMAND),
        *(f"{k}. {sentence}" for k, sentence in enumerate(found["findings"], start=1)),
        "\n![Bias of four parameters against noise per step](figures/study-noise.svg)\n",
        "Median over cells; lines are the closed form.\n",
        f"## Guidance\n\n{GUIDANCE}\n",
        _table(bits_table(found["guidance"])),
        _table(frames_table(found["guidance"])),
    ]
    target = HERE / "study-gradient-quantization.md"
    target.write_text("\n".join(parts), encoding="utf-8")


HEAD = """\
# Lighting gradient against quantization

Written by `make docs` from `docs/results/gradient-quantization.parquet`, which `make study` makes:
{cells} cells of {seeds} bodies, of the 1080 combinations of five places of the lamp, two lamps,
8, 10 and 12 bits, three gains, six levels of noise per step and two of defocus. To explore it, open
`camtruth-out/docs/study.html` after `make docs`, or run it yourself:

    {command}

## Findings
"""


def _figure(rows: list[dict[str, object]]) -> str:
    x = [float(np.log10(v)) for v in NOISE_STEPS]
    plots = []
    for key in KEYS:
        marks = []
        every: list[float] = []
        for name, style in STYLES.items():
            own = select(rows, method=name, parameter=key)
            for column, kind in (("predicted_bias", "line"), ("bias", "dots")):
                of = [relative(select(own, noise_steps=s), column) for s in NOISE_STEPS]
                y = [100 * float(np.median(v)) if v.size else float("nan") for v in of]
                marks.append(Marks(x=x, y=y, style=style, kind=kind))  # type: ignore[arg-type]
                every += y
        axis = Axis(low=min(x) - 0.05, high=max(x) + 0.05, label="log10 of noise / steps")
        plots.append(plot(WORDS[key], axis, axis_over(every, "bias / % of the truth"), marks))
    return sheet(plots, 2, [(f"dots {style}", name) for name, style in STYLES.items()])


def _table(table: object) -> str:
    heads, rows = table.heads, table.rows  # type: ignore[attr-defined]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"
