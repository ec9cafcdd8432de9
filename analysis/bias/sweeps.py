"""What the bias depends on: one quantity varied at a time around the paper's case."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from analysis.bias.setting import Setting


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """One quantity and the places it is taken to; `field` is the setting's."""

    field: str
    label: str
    values: tuple[Any, ...]
    base: Setting = dataclasses.field(default_factory=Setting)

    def settings(self) -> list[Setting]:
        """A setting for each value."""
        return [dataclasses.replace(self.base, **{self.field: value}) for value in self.values]


SWEEPS: Mapping[str, Sweep] = {
    "frames": Sweep(field="frames", label="frames of a shot", values=(5, 10, 20, 50, 100, 300)),
    "size": Sweep(field="size_px", label="side of a panel / px", values=(12, 20, 30, 40, 50, 60)),
    "read": Sweep(
        field="read_dn",
        label="read noise / DN",
        values=(0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0),
    ),
    "fpn": Sweep(field="fpn_dn", label="FPN / DN", values=(0.05, 0.1, 0.2, 0.4, 0.8, 1.5)),
    "black": Sweep(
        field="black_dn",
        label="black level / DN",
        values=(0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0),
    ),
    "level": Sweep(field="level", label="light, of the paper's", values=(0.1, 0.25, 0.5, 1.0, 1.5)),
    "exposure": Sweep(
        field="exposure",
        label="exposure, of the paper's, in a camera with dark current (icx098)",
        values=(0.1, 0.25, 0.5, 1.0, 1.5),
        base=Setting(camera="icx098"),
    ),
    "gradient": Sweep(
        field="gradient", label="gradient, of the lamp's", values=(0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
    ),
    "step": Sweep(
        field="step_dn",
        label="step of rounding / DN (8 to 12 bits)",
        values=(1.0, 0.5, 0.25, 0.125, 0.0625),
    ),
    "defocus": Sweep(field="blur_px", label="further defocus / px", values=(None, 2.0, 6.0, 12.0)),
    "demosaic": Sweep(field="demosaic", label="demosaic", values=(True, False)),
}


def all_settings() -> dict[str, Setting]:
    """Every setting of every sweep by slug, once."""
    found = [setting for sweep in SWEEPS.values() for setting in sweep.settings()]
    return {setting.slug: setting for setting in found}
