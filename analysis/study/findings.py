"""A sentence for each finding of the study, with its figures, and guidance at the end."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from analysis.bias.rounding import Floats
from analysis.study.bench import BRIGHTEST_DN8, FRAMES
from analysis.study.design import BITS, ELECTRONS_PER_DN8, LAMP_PLACES, NOISE_STEPS

Row = Mapping[str, Any]
KEYS = ("read", "gain", "fpn", "prnu")
GOOD = 0.02
"""A bias up to this share of the truth is called right."""

WANTED = 0.01
"""Scatter of a single capture, relative, that guidance on frames is for."""

WORDS = {"read": "read noise", "gain": "gain", "fpn": "FPN", "prnu": "PRNU"}


def relative(rows: Sequence[Row], column: str = "bias") -> Floats:
    """A column as a share of the truth; rows without a figure are left out."""
    return np.array([row[column] / row["truth"] for row in rows if row[column] is not None])


def select(rows: Sequence[Row], **fixed: Any) -> list[Row]:
    """Rows that have these values."""
    return [row for row in rows if all(row[name] == value for name, value in fixed.items())]


def findings(rows: Sequence[Row]) -> list[str]:
    """What the rows show."""
    methods = list(dict.fromkeys(row["method"] for row in rows))
    found = [_ramp(rows), _prediction(rows)]
    found += [_method(rows, name) for name in methods]
    found += [_noise(rows, methods), _dither(rows), _defocus(rows), _lamps(rows)]
    return [sentence for sentence in found if sentence]


def _ramp(rows: Sequence[Row]) -> str:
    """Photon transfer takes no shading off: how its PRNU grows with the ramp."""
    own = [
        row
        for row in select(rows, method="photon_transfer", parameter="prnu")
        if row["estimate"] is not None and row["rise_dn8"] / row["level_dn8"] > 0.05
    ]
    if not own:
        return ""
    excess = np.array([math.sqrt(max(r["estimate"] ** 2 - r["truth"] ** 2, 0)) for r in own])
    rise = np.array([r["rise_dn8"] / r["level_dn8"] for r in own])
    share = float(np.median(excess / (rise / math.sqrt(12))))
    return (
        "A ramp that rises by r of its mean over the panel, not taken off, is read as PRNU of"
        f" r / √12: photon transfer without a high-pass reads {share:.2f} times that in the median"
        f" of {len(own)} figures, up to {float(excess.max()):.0%} of PRNU where the truth is 1 %."
    )


def _prediction(rows: Sequence[Row]) -> str:
    both = [
        r
        for r in rows
        if r["bias"] is not None and r["predicted_bias"] is not None and r["method"] != "corrected"
    ]
    if not both:
        return ""
    off = np.array([abs(r["bias"] - r["predicted_bias"]) for r in both])
    size = np.array([abs(r["bias"]) for r in both])
    noise = np.array([r["bias_se"] or 0.0 for r in both])
    room = np.maximum(0.02 * np.array([r["truth"] for r in both]), 3 * noise)
    explained = 1 - float(np.sum(off**2 / room**2)) / float(np.sum(size**2 / room**2))
    return (
        f"The closed form foretells the bias: {float(np.mean(off <= room)):.0%} of {len(both)}"
        " figures lie within 2 % of the truth or three standard errors of it, and"
        f" {explained:.1%} of the squared bias is explained."
    )


def _method(rows: Sequence[Row], name: str) -> str:
    parts = []
    for key in KEYS:
        own = select(rows, method=name, parameter=key)
        bias = np.abs(relative(own))
        if not bias.size:
            continue
        answered = bias.size / len(own)
        least = f" where it answers, in {answered:.0%} of cells" if answered < 0.995 else ""
        parts.append(
            f"{WORDS[key]} by {float(np.median(bias)):.1%} in the median and"
            f" {float(np.percentile(bias, 90)):.1%} at the ninetieth percentile{least}"
        )
    return f"{name} misses {'; '.join(parts)}." if parts else ""


def _noise(rows: Sequence[Row], methods: Sequence[str]) -> str:
    parts = []
    for name in methods:
        least = least_noise(select(rows, method=name, parameter="read"))
        parts.append(f"{name} from {least:g}" if least else f"{name} at none of the levels")
    return (
        f"Read noise in steps from which it is right to {GOOD:.0%} in nearly all cells:"
        f" {', '.join(parts)}."
    )


def least_noise(rows: Sequence[Row], share: float = 0.9) -> float | None:
    """The least noise per step from which most cells are right, at it and at all above it."""
    least = None
    for noise in reversed(NOISE_STEPS):
        own = select(rows, noise_steps=noise)
        good = [r for r in own if right(r)]
        if not own or len(good) < share * len(own):
            break
        least = noise
    return least


def right(row: Row) -> bool:
    """Whether a row has a figure whose bias is small, or lost in the study's own scatter."""
    if row["bias"] is None or row["answered"] < 0.5:
        return False
    return bool(abs(row["bias"]) <= max(GOOD * row["truth"], 2.5 * (row["bias_se"] or 0.0)))


HARDLY = 0.2
"""Part of an error by which another one must differ to be called better or worse: the scatter of a
ninetieth percentile."""


def _dither(rows: Sequence[Row]) -> str:
    """Whether a ramp that sweeps the codes stands in for noise that does not."""

    def spread(places: Sequence[str]) -> float:
        own = [
            r
            for r in select(
                rows, method="photon_transfer", parameter="gain", electrons_per_dn8=66.0
            )
            if r["place"] in places and r["noise_steps"] <= 0.2 and r["bits"] == 8
        ]
        return float(np.percentile(np.abs(relative(own)), 90)) if own else math.nan

    even, ramp = spread(["even"]), spread(["paper", "near", "close"])
    if math.isnan(even) or math.isnan(ramp):
        return ""
    if abs(ramp - even) < HARDLY * even:
        word = "hardly changes that"
    else:
        word = "helps" if ramp < even else "makes it worse"
    return (
        "A gradient sweeps levels over the codes, so that rounding adds 1/12 on the average: at"
        " read noise of 0.2 steps and less, 8 bits and 66 electrons a step the gain of photon"
        f" transfer is off by up to {even:.1%} under even light and {ramp:.1%} under a ramp (90th"
        f" percentile). It {word}, and it does nothing for dark frames, which have no ramp."
    )


def _defocus(rows: Sequence[Row]) -> str:
    by_cell: dict[tuple[Any, ...], dict[float, Row]] = {}
    fixed = ("place", "lamp", "bits", "electrons_per_dn8", "noise_steps", "channel", "method")
    for row in rows:
        key = (*(row[name] for name in fixed), row["parameter"])
        by_cell.setdefault(key, {})[row["blur_px"]] = row
    pairs = [
        (of[max(of)], of[min(of)])
        for of in by_cell.values()
        if len(of) > 1 and all(r["bias_se"] for r in of.values())
    ]
    if not pairs:
        return ""
    change = [(a["bias"] - b["bias"]) / a["truth"] for a, b in pairs]
    beyond = [
        abs(a["bias"] - b["bias"]) > 3 * math.hypot(a["bias_se"], b["bias_se"]) for a, b in pairs
    ]
    return (
        "Defocus inside a panel changes nothing that can be seen: 6 px more move the bias by"
        f" {float(np.mean(change)):+.2%} of the truth in the mean of {len(pairs)} pairs of cells,"
        f" and by more than three standard errors in {float(np.mean(beyond)):.1%} of them, where"
        " errors from a few bodies let chance do so in a few percent."
    )


def _lamps(rows: Sequence[Row]) -> str:
    parts = []
    for lamp in dict.fromkeys(row["lamp"] for row in rows):
        own = {
            c: select(rows, lamp=lamp, channel=c, method="corrected", parameter="gain")
            for c in "RGB"
        }
        level = {c: np.mean([r["level_dn8"] for r in of]) for c, of in own.items() if of}
        scatter = {c: _typical(of) for c, of in own.items()}
        if not level:
            return ""
        parts.append(
            f"under the {lamp} lamp red, green and blue are at"
            f" {', '.join(f'{level[c]:.0f}' for c in level)} DN and their gain scatters by"
            f" {', '.join(f'{scatter[c]:.1%}' for c in level)}"
        )
    return (
        "The lamp's spectrum acts through the level of each colour, by scatter and not by bias: "
        + "; ".join(parts)
        + "."
    )


def _typical(rows: Sequence[Row]) -> float:
    """Median relative scatter of single captures, each from few bodies."""
    values = [r["scatter"] / r["truth"] for r in rows if r["scatter"] is not None]
    return float(np.median(values)) if values else math.nan


def guidance(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """For each gradient, lamp and estimator: noise in steps to have, and frames to take.

    Least noise: from which a parameter is right in all channels, so that a camera of known read
    noise has its bits (`bits_for`). Frames: how many bring the scatter of the gain, which falls
    with their root, to 1 % in the worst colour. A gradient and lamp with missing cells get none.
    """
    found = []
    lamps = dict.fromkeys(row["lamp"] for row in rows)
    for place in LAMP_PLACES:
        for lamp in lamps:
            for name in dict.fromkeys(row["method"] for row in rows):
                own = select(rows, place=place, lamp=lamp, method=name)
                factors = {(r["noise_steps"], r["bits"], r["electrons_per_dn8"]) for r in own}
                if len(factors) == len(NOISE_STEPS) * len(BITS) * len(ELECTRONS_PER_DN8):
                    found.append(
                        {
                            "place": place,
                            "lamp": lamp,
                            "rise": max(r["rise_dn8"] / r["level_dn8"] for r in own),
                            "method": name,
                            "least_noise_steps": {
                                key: least_noise(select(own, parameter=key), 0.85) for key in KEYS
                            },
                            "frames": {
                                f"{electrons:g}": _frames(own, electrons)
                                for electrons in ELECTRONS_PER_DN8
                            },
                        }
                    )
    return found


def bits_for(noise_steps: float | None, read_dn8: float) -> int | None:
    """The fewest bits of the study at which a read noise in DN of 8 bits is so many steps."""
    if noise_steps is None:
        return None
    return next((b for b in BITS if read_dn8 * 2.0 ** (b - 8) >= noise_steps), None)


def _frames(rows: Sequence[Row], electrons: float) -> int | None:
    worst = [
        _typical(select(rows, electrons_per_dn8=electrons, parameter="gain", channel=c))
        for c in "RGB"
    ]
    scatter = max((w for w in worst if not math.isnan(w)), default=math.nan)
    if math.isnan(scatter):
        return None
    return max(2, math.ceil(FRAMES * (scatter / WANTED) ** 2))


def document(rows: Sequence[Row], seeds: int) -> dict[str, Any]:
    """The study's answer as data."""
    return {
        "format": "camtruth-study/1",
        "study": "gradient-quantization",
        "seeds": seeds,
        "cells": len({tuple(r[k] for k in ("place", "lamp", "bits", "electrons_per_dn8",
                                            "noise_steps", "blur_px")) for r in rows}),
        "rows": len(rows),
        "brightest_dn8": BRIGHTEST_DN8,
        "findings": findings(rows),
        "guidance": guidance(rows),
    }  # fmt: skip
