"""docs/bias.md: where estimators are biased and why, from the results of `make bias`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from analysis.bias.causes import CAUSES, shares
from analysis.bias.domain import KEYS
from analysis.bias.setting import Setting
from camtruth.terminal import with_error
from docs import bias_figures
from docs.bias_figures import NAMES, SHOWN

HERE = Path(__file__).parent
RESULTS = HERE / "results"
FIGURES = HERE / "figures" / "bias"
COLOURS = {"R": "red", "G": "green", "B": "blue"}
UNITS = {"read": "DN", "fpn": "DN", "shot_coefficient": "DN^0.5", "prnu_slope": "1"}
CAMERAS = ("i400", "icx098")
RIVALS = "irie-emva1288-photon_transfer-corrected"
ALIASES = {"gain": "shot_coefficient", "fpn": "dsnu", "prnu": "prnu_slope"}
METHODS = ("irie", "emva1288", "photon_transfer", "corrected")

Document = Mapping[str, Any]


def write_bias_page() -> None:
    """The page and its figures, from what `make bias` has left."""
    cells = _read("cells")
    failures = _read("failures")
    FIGURES.mkdir(parents=True, exist_ok=True)
    for name in SHOWN:
        _figure(f"sweep-{name}", bias_figures.sweep_figure(name, cells["cells"]))
    _figure("domain", bias_figures.domain_figure())
    _figure("tell", bias_figures.tell_figure(failures["tell_map"]))
    _figure("ramp", bias_figures.ramp_figure(failures["ramps"]))
    _figure("rounding", bias_figures.rounding_figure(failures["rounding"]))
    text = "\n".join(
        [
            HEAD,
            _case(cells),
            _causes(cells["cells"]),
            _sweeps(cells),
            DOMAIN,
            _coverage(),
            _rivals(),
            _failing(failures),
        ]
    )
    (HERE / "bias.md").write_text(text, encoding="utf-8")


HEAD = """\
# Where estimators are biased, and why

Written by `make docs` from the results of `make bias`. Every figure is of simulated cameras, whose
truth is known; the light is the closed form's; only panels are simulated. A closed form of what the
printed technique must read (`analysis/bias/prediction.py`) stands beside each simulated bias.
"""

DOMAIN = """\
## Where the technique holds

In closed form, for a red channel like the i400's (gain 0.045 DN/e-, read noise 1.6 DN, FPN 0.3 DN,
PRNU 1 %, black level 6 DN, 100 frames), two quantities varied at a time. Green: right to 2 %; light
green: 5 %; yellow: 10 %; red: worse.

![Four maps of the domain](figures/bias/domain.svg)

`camtruth measure --method irie` finds the camera behind its own figures by the same closed
form, and warns with the expected bias when it is beyond 2 %.

Where the corrected estimator can tell the noise of 8-bit dark frames at all: grey is no answer,
which it says with its reason. It needs a quarter of a step and a black level above 0.

![Map of where the noise can be told](figures/bias/tell.svg)
"""


def _case(cells: Document) -> str:
    base = cells["cells"][Setting().slug]
    rows = []
    for channel in "RGB":
        for key in KEYS:
            true = base["truth"][channel][key]
            printed = base["techniques"]["printed"][channel][key]
            repaired = base["techniques"]["repaired"][channel][key]
            rows.append(
                (
                    COLOURS[channel],
                    NAMES[key],
                    f"{true:g} {_unit(key)}".strip(),
                    with_error(printed["bias"], printed["se"]),
                    f"{printed['expected']:+.4f}",
                    f"{100 * printed['bias'] / true:+.1f} %",
                    with_error(repaired["bias"], repaired["se"]),
                )
            )
    heads = ("colour", "figure", "truth", "bias", "closed form", "of the truth", "repaired")
    return (
        "## The paper's case\n\nThe camera `i400`, the paper's protocol,"
        f' {cells["seeds"]} bodies. "Repaired" is the technique with every step of its arithmetic'
        " exchanged for an exact one; what is left is clipping of darks at 0, which arithmetic on"
        " standard deviations cannot undo.\n\n" + _table(heads, rows)
    )


def _causes(cells: Document) -> str:
    words = "\n".join(f"- **{name}**: {cause.words}." for name, cause in CAUSES.items())
    parts = [
        "## Because of what\n\nEach cause switched off alone, on the same bodies; what the bias"
        " loses with it, simulated and, in brackets, in closed form. Shares do not add up to the"
        f" bias: causes work on each other.\n\n{words}\n"
    ]
    for key in KEYS:
        rows = []
        for channel in "RGB":
            found = shares(cells, channel, key)
            base = cells[Setting().slug]["techniques"]["printed"][channel][key]
            line = [COLOURS[channel], f"{base['bias']:+.4f} ({base['expected']:+.4f})"]
            line += [f"{change:+.4f} ({ahead:+.4f})" for change, _, ahead in found.values()]
            rows.append(tuple(line))
        unit = f", {_unit(key)}" if _unit(key) else ""
        heads = ("colour", "bias", *CAUSES)
        parts.append(f"### {NAMES[key]}{unit}\n\n" + _table(heads, rows))
        parts += [_sentence(cells, channel, key) for channel in "RGB"]
    return "\n".join(parts)


def _sentence(cells: Document, channel: str, key: str) -> str:
    """Of red's FPN bias of x, y comes from ..., z from ..."""
    base = cells[Setting().slug]["techniques"]["printed"][channel][key]
    found = shares(cells, channel, key)
    largest = sorted(found, key=lambda name: -abs(found[name][0]))[:3]
    clear = [name for name in largest if abs(found[name][0]) > 3 * found[name][1]]
    listed = "; ".join(f"{found[name][0]:+.4f} with '{name}'" for name in clear)
    return (
        f"Of {COLOURS[channel]}'s {NAMES[key]} bias of {base['bias']:+.4f} {_unit(key)}".rstrip()
        + (f" goes away: {listed}.\n" if listed else " no cause alone takes a part.\n")
    )


def _sweeps(cells: Document) -> str:
    parts = [
        "## Bias against what causes it\n\nOne quantity varied, the rest as in the paper's case."
        f" {cells['seeds']} bodies each; bars are one standard error. Below 20 frames the closed"
        " form of read noise departs: its expansion in one over the number of frames does not hold"
        " for noise below a step.\n"
    ]
    parts += [f"![Bias against {name}](figures/bias/sweep-{name}.svg)\n" for name in SHOWN]
    rows = []
    for slug, words in (
        (Setting().slug, "bilinear demosaic"),
        (Setting(demosaic=False).slug, "native sites"),
        (Setting(blur_px=6.0).slug, "6 px of further defocus"),
        (Setting(blur_px=12.0).slug, "12 px of further defocus"),
    ):
        if slug in cells["cells"]:
            of = cells["cells"][slug]
            for channel in "RGB":
                line = [words, COLOURS[channel]]
                for key in KEYS:
                    bias = of["techniques"]["printed"][channel][key]
                    line.append(f"{100 * bias['bias'] / of['truth'][channel][key]:+.1f} %")
                rows.append(tuple(line))
    parts.append(_table(("", "colour", *(NAMES[key] for key in KEYS)), rows))
    return "\n".join(parts)


def _coverage() -> str:
    parts = [
        "## The corrected estimator\n\n`--method corrected`, the paper's protocol. Wanted: bias"
        " below 1 % or a quarter of the standard error, whichever is larger, and 95 % intervals"
        " that hold the truth in 93 to 97 % of captures.\n"
    ]
    for camera in CAMERAS:
        path = RESULTS / f"coverage-{camera}-corrected.json"
        if not path.is_file():
            continue
        known = json.loads(path.read_text(encoding="utf-8"))
        rows = [
            (
                COLOURS[row["channel"]],
                row["parameter"],
                f"{row['truth']:.5g} {row['unit']}".removesuffix(" 1"),
                f"{100 * row['bias_of_truth']:+.3f} %",
                f"{row['bias_of_scatter']:+.3f}",
                f"{100 * row['coverage']:.1f} %",
                "yes" if _reached(row) else "**no**",
            )
            for row in known["rows"]
            if row["parameter"] in ("read", "gain", "fpn", "prnu") and row["bias"] is not None
        ]
        parts.append(
            f"### {camera}: {known['seeds']} bodies, {known['date']}, commit {known['commit']}\n\n"
            + _table(
                ("colour", "figure", "truth", "bias", "in errors", "coverage", "reached"), rows
            )
        )
    return "\n".join(parts)


def _reached(row: Document) -> bool:
    small = abs(row["bias_of_truth"]) < 0.01 or abs(row["bias_of_scatter"]) < 0.25
    return bool(small and 0.93 <= row["coverage"] <= 0.97)


def _rivals() -> str:
    parts = [
        "## Rivals on the same frames\n\nBias as a share of the truth, and coverage of 95 %"
        " intervals. EMVA 1288 and photon transfer are made for raw frames: their second table is"
        " fair to them, the first shows what a demosaic does to them. `gain` of irie is the square"
        " of its shot coefficient. The package emva1288 itself reads our exported frames in"
        " `tests/test_exchange_export.py`, and agrees.\n"
    ]
    for camera in CAMERAS:
        for raw, words in (("", "colour frames"), ("-raw", "raw frames")):
            path = RESULTS / f"coverage-{camera}{raw}-{RIVALS}.json"
            if path.is_file():
                known = json.loads(path.read_text(encoding="utf-8"))
                parts.append(f"### {camera}, {words}: {known['seeds']} bodies\n")
                parts.append(_rival_table(known["rows"]))
    return "\n".join(parts)


def _rival_table(rows: Sequence[Document]) -> str:
    by_place = {(r["method"], r["channel"], r["parameter"]): r for r in rows}
    lines = []
    for channel in "RGB":
        for key in ("read", "gain", "fpn", "prnu"):
            cells = [COLOURS[channel], key]
            for name in METHODS:
                for other in (key, ALIASES.get(key)):
                    row = by_place.get((name, channel, other or key))
                    if row is not None:
                        break
                cells.append(
                    _rival(row, squared=bool(row) and row["parameter"] != key and key == "gain")
                )
            lines.append(tuple(cells))
    return _table(("colour", "figure", *METHODS), lines)


def _rival(row: Document | None, *, squared: bool) -> str:
    if row is None or row["bias"] is None:
        return "no answer"
    share = row["estimate"] / row["truth"]
    share = share**2 if squared else share
    some = "" if row["answered"] > 0.99 else f", answers {row['answered']:.0%}"
    return f"{100 * (share - 1):+.1f} %, {100 * row['coverage']:.0f} %{some}"


def _failing(failures: Document) -> str:
    none = failures["none_at_all"]
    rows = [
        (
            COLOURS[channel],
            *(
                f"{100 * none['read'][channel][name]:.2f} % in {none['told'][channel][name]}"
                f" of {none['seeds']}"
                if name in none["read"][channel]
                else "none"
                for name in METHODS
            ),
        )
        for channel in "RGB"
    ]
    return (
        "## Cases that go wrong\n\n**A lighting ramp read as PRNU.** Without a high-pass or a fit a"
        " ramp that rises by r is read as PRNU of r/√12 (dashed); truth is 1 %.\n\n"
        "![A ramp read as PRNU](figures/bias/ramp.svg)\n\n"
        "**Rounded twice, truncated.** A simulator that dithers to codes, scales and rounds again"
        " adds 1/12 more than once, and no estimator that is told one rounding can know. Truncation"
        " leaves noise as it is and moves every level by half a step, which counts as black"
        " level.\n\n![Rounding](figures/bias/rounding.svg)\n\n"
        "**PRNU where there is none.** The i400 raw, its PRNU switched off:\n\n"
        + _table(("colour", *METHODS), rows)
    )


def _read(name: str) -> Document:
    found: Document = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return found


def _figure(name: str, svg: str) -> None:
    (FIGURES / f"{name}.svg").write_text(svg, encoding="utf-8")


def _unit(key: str) -> str:
    return "" if UNITS[key] == "1" else UNITS[key]


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"
