"""Photon transfer by frame differences: right where its model holds, wrong on a ramp."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.estimators.photon_transfer import photon_transfer
from foundation.panel import Panel
from sensor.frames import Capture, Frames, Shot
from tests.harness import assert_agree

SIDE, GAIN, READ, FPN, PRNU, BLACK = 48, 0.5, 3.0, 1.5, 0.02, 40.0
LEVELS = (0.0, 100.0, 400.0, 1600.0)


def capture(seed: int, ramp: float = 0.0, frames: int = 40) -> Capture:
    """Mono frames of 12 bits, whose rounding does not matter; `ramp` is relative over the panel."""
    rng = np.random.default_rng(seed)
    offset, response = rng.normal(size=(2, SIDE, SIDE))
    slope = 1 + ramp * np.linspace(-0.5, 0.5, SIDE)
    taken = []
    for level in LEVELS:
        light = level * slope * (1 + PRNU * response)
        spread = np.sqrt(READ**2 + GAIN * np.maximum(light, 0))
        dn = BLACK + light + FPN * offset + spread * rng.normal(size=(frames, SIDE, SIDE))
        shot = Shot(
            label=f"{level:g}",
            light=("lamp",) if level else ("none",),
            level=(level or 1.0,),
            exposure_s=0.01,
            frames=frames,
        )
        codes = np.clip(np.rint(dn), 0, 4095).astype(np.uint16)
        taken.append(Frames(dn=codes, shot=shot, pixels="mono16", bits=12))
    panel = Panel(name="all", x=0, y=0, w=SIDE, h=SIDE)
    return Capture(camera="test", frames=tuple(taken), panels=(panel,))


def test_what_went_in_comes_out_under_even_light():
    """Rounding adds 1/12 to 9: half a percent of read noise, which belongs to the method."""
    found = [photon_transfer(capture(seed)).channels["Y"] for seed in range(12)]
    true = {"read": (READ**2 + 1 / 12) ** 0.5, "gain": GAIN, "fpn": FPN, "prnu": PRNU}
    values = np.array([[of[key].value for key in true] for of in found])
    assert_agree(
        values.mean(axis=0), list(true.values()), values.std(axis=0, ddof=1) / 12**0.5 * 1.15
    )


def test_a_ramp_of_light_counts_as_prnu():
    """A ramp from -r/2 to r/2 has the variance r^2/12, which adds to PRNU's square."""
    found = photon_transfer(capture(1, ramp=0.05)).channels["Y"]["prnu"]
    assert_agree(found.value, (PRNU**2 + 0.05**2 / 12) ** 0.5, found.se)


@pytest.mark.parametrize(("kept", "said"), [(slice(0, 1), "no lit"), (slice(1, 4), "no dark")])
def test_half_a_protocol_is_no_line(kept, said):
    whole = capture(2)
    part = Capture(camera="test", frames=whole.frames[kept], panels=whole.panels)
    assert said in photon_transfer(part).channels["Y"]["gain"].reason
