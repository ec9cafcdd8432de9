"""What becomes of the light when the camera's response is not quite what one thinks it is.

The response of a camera is seldom known better than to 10 or 20 % a channel. Here each channel is
changed by itself, by a part e, in four ways that keep its tallest value at 1 + e or 1:

    level    times 1 + e at all wavelengths
    tilt     times 1 + e u, u running from -1 at 400 nm to 1 at 700 nm
    hump     times 1 + e exp(-u^2 / 0.18), in the middle of the spectrum
    leak     e / 10 of the peak at all wavelengths besides: light where the table sees little

Panels are matt and lamps keep their spectra, so that one channel of one panel is changed by one
factor, everywhere in the panel. Rates scale with it; what a noise estimator reads out of a panel in
ratios (PRNU, shot noise coefficient) does not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.errors import RenderError
from render.spectral import material_rates
from scenes.lamp import Lamp
from scenes.patches import GREY_ROW, patches
from scenes.scene import Scene
from scenes.spectra import CHANNELS, VISIBLE_NM, Spectrum, response, spectrum

Array = NDArray[np.float64]
LEAST, MOST = 1e-3, 0.5
LEAK = 0.1


def _along(nm: Array) -> Array:
    """-1 at 400 nm, 1 at 700 nm."""
    low, high = VISIBLE_NM
    return np.asarray(np.clip((2 * nm - low - high) / (high - low), -1, 1))


KINDS: dict[str, Callable[[Spectrum, float], Array]] = {
    "level": lambda curve, e: curve.value * (1 + e),
    "tilt": lambda curve, e: curve.value * (1 + e * _along(curve.nm)),
    "hump": lambda curve, e: curve.value * (1 + e * np.exp(-(_along(curve.nm) ** 2) / 0.18)),
    "leak": lambda curve, e: curve.value + LEAK * e * curve.value.max(),
}


@dataclass(frozen=True, kw_only=True)
class Change:
    """What one perturbation of one channel does to its rates under one lamp.

    Attributes:
        lamp, channel, kind: which.
        size: the part e.
        grey: change of the rate of the grey panels, relative, averaged over them.
        spread: largest departure of a grey panel from that average: what no change of level mends.
        worst: largest change of any panel.
        panel: which panel that is.
        shot_noise: what `grey` makes of the shot noise in DN, relative: its square root.
    """

    lamp: str
    channel: str
    kind: str
    size: float
    grey: float
    spread: float
    worst: float
    panel: str
    shot_noise: float


def changes(scene: Scene, lamp: Lamp, size: float) -> list[Change]:
    """Every kind of perturbation of every channel under a lamp.

    Raises:
        RenderError: for a size that is no small part.
    """
    if not LEAST <= size <= MOST:
        raise RenderError(
            f"a perturbation of {size:g}", f"expected {LEAST:g} to {MOST:g}", "try 0.1 or 0.2"
        )
    curves = response(scene.detector.response, scene.detector.infrared_cut)
    names = [patch.name for patch in patches(scene.chart)]
    grey = [names.index(n) for n in GREY_ROW if n in names] or list(range(len(names)))
    before = material_rates(scene, lamp, curves)[: len(names)]
    result = []
    for kind in KINDS:
        for index, channel in enumerate(CHANNELS):
            other = perturbed(curves, channel, kind, size)
            after = material_rates(scene, lamp, other)[: len(names), index]
            ratio = np.divide(
                after, before[:, index], out=np.ones_like(after), where=before[:, index] > 0
            )
            mean = float(ratio[grey].mean())
            worst = int(np.abs(ratio - 1).argmax())
            result.append(
                Change(
                    lamp=lamp.name,
                    channel=channel,
                    kind=kind,
                    size=size,
                    grey=mean - 1,
                    spread=float(np.abs(ratio[grey] - mean).max()),
                    worst=float(ratio[worst] - 1),
                    panel=names[worst],
                    shot_noise=math.sqrt(mean) - 1,
                )
            )
    return result


def perturbed(
    curves: Mapping[str, Spectrum], channel: str, kind: str, size: float
) -> dict[str, Spectrum]:
    """The three responses with one of them changed."""
    curve = curves[channel]
    return {**curves, channel: spectrum(curve.nm, KINDS[kind](curve, size))}
