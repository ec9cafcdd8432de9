"""The known causes of the technique's bias, each switched off alone, and what each one costs.

A cause of the arithmetic is a step of the technique that is exchanged; one of the frames is a
setting of the simulation. Both are measured on the same bodies as the printed technique in the
paper's case, so their difference has a far smaller error than either bias.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.bias.setting import Setting
from analysis.bias.technique import PRINTED, REPAIRED, Technique

FINE = 1 / 16
"""Step of rounding that stands for none, in DN."""


@dataclass(frozen=True, kw_only=True)
class Cause:
    """A cause and how to do without it.

    Attributes:
        words: what is to blame.
        technique, setting: what is measured and how when it is switched off.
        beside: name of the technique that it is compared with in the paper's case.
    """

    words: str
    technique: Technique = PRINTED
    setting: Setting = dataclasses.field(default_factory=Setting)
    beside: str = "printed"


CAUSES: Mapping[str, Cause] = {
    "subtraction": Cause(
        words="SDs are subtracted where variances add",
        technique=Technique(variances=True),
    ),
    "residual": Cause(
        words="averaging N frames leaves 1/N of the variance in time in the spatial figure",
        technique=Technique(less_residual=True),
    ),
    "freedom": Cause(
        words="column fits take more degrees of freedom of correlated noise than Table V allows",
        technique=Technique(exact_freedom=True),
    ),
    "sites": Cause(
        words="N_D in time is a mean of SDs that differ from site to site",
        technique=Technique(exact_sites=True),
    ),
    "rounding": Cause(
        words="the curves of N_Q are for patterns without noise in time to stir them, and for one"
        " gradient",
        technique=Technique(exact_rounding=True),
    ),
    "black": Cause(
        words="noise is held against the mean with the black level in it",
        technique=Technique(above_black=True),
    ),
    "clipping": Cause(
        words="dark frames clip at 0 DN (held against the mean above black, which moves with it)",
        technique=Technique(above_black=True),
        setting=Setting(black_dn=20.0),
        beside="black",
    ),
    "gradient": Cause(
        words="the lamp's gradient: shading and rounding of a ramp",
        setting=Setting(gradient=0.0),
    ),
    "steps": Cause(
        words="frames are rounded to whole DN",
        technique=Technique(exact_rounding=True, step_variance=0.0),
        setting=Setting(step_dn=FINE),
    ),
}

WHOLE = {"printed": PRINTED, "repaired": REPAIRED}


def techniques() -> dict[str, Technique]:
    """Everything that is measured on each body: printed, each step exchanged alone, all of them."""
    alone = {
        name: cause.technique
        for name, cause in CAUSES.items()
        if cause.technique != PRINTED and cause.beside == "printed"
    }
    return WHOLE | alone


def settings() -> dict[str, Setting]:
    """The paper's case, and each cause of the frames switched off alone."""
    varied = [cause.setting for cause in CAUSES.values() if cause.setting != Setting()]
    whole = [Setting(), *varied, Setting(black_dn=20.0, gradient=0.0)]
    return {setting.slug: setting for setting in whole}


def shares(
    cells: Mapping[str, Mapping[str, Any]], channel: str, key: str
) -> dict[str, tuple[float, float, float]]:
    """What of the printed technique's bias each cause takes with it when it is switched off.

    Args:
        cells: results of `analysis.bias.experiment.run_cell` by slug, of `settings()`.
        channel, key: of the parameter.

    Returns:
        by cause: the change of the bias, its standard error, and the closed form's.
    """
    found = {}
    for name, cause in CAUSES.items():
        base = cells[Setting().slug]["techniques"][cause.beside][channel][key]
        technique = name if name in techniques() else cause.beside
        off = cells[cause.setting.slug]["techniques"][technique][channel][key]
        change = np.array(base["each"]) - np.array(off["each"])
        se = float(change.std(ddof=1) / math.sqrt(change.size))
        found[name] = (float(change.mean()), se, base["expected"] - off["expected"])
    return found
