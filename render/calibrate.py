"""How the lamps of a preset were adjusted: intensity and gel that make grey look grey.

The paper adjusted "each light source to provide similar camera RGB response for a gray-scale
image". A camera without colour gains leaves one way: a gel in front of the lamp. Scaling the
intensity matches one channel; the other two need two numbers more, which are those of the two
common gels, a colour conversion (blue or amber) and a green correction (magenta or green).
The gel is smooth, so mercury lines stay lines. The result is written into the preset as data;
this file is how to adjust a new lamp.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from render import closed_form
from render.errors import RenderError
from scenes.geometry import panel_rectangles, project
from scenes.lamp import Filter, Lamp
from scenes.scene import Scene
from scenes.spectra import CHANNELS


def panel_rate(scene: Scene, lamp: Lamp, panel: str) -> NDArray[np.float64]:
    """R, G, B of the pixel at the centre of a panel in e-/s, by the closed form."""
    where = panel_rectangles(scene)[panel]
    column, row = project(
        scene, (where.left_m + where.right_m) / 2, (where.bottom_m + where.top_m) / 2
    )
    image = closed_form.render(scene, lamp).rate_e_per_s
    return np.asarray(image[int(row), int(column)], dtype=np.float64)


def adjusted(scene: Scene, lamp: Lamp) -> Lamp:
    """The lamp with the gel that equalises R, G and B on the scene's calibration panel, and the
    intensity that gives its assumed rate there.

    Raises:
        RenderError: when no gel within the limits of `Filter` does it.
    """
    target = scene.calibration

    def behind(numbers: NDArray[np.float64]) -> Lamp:
        gel = Filter(mired_shift=float(numbers[0]) * 100, green_density=float(numbers[1]))
        return dataclasses.replace(lamp, filter=gel)

    def imbalance(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        red, green, blue = panel_rate(scene, behind(numbers), target.panel)
        return np.log([red / green, blue / green])

    found = root(imbalance, np.zeros(2), tol=1e-6)
    if not found.success:
        raise RenderError(
            f"no gel makes grey equal in R, G and B under lamp '{lamp.name}'",
            "expected a lamp with light in all three channels",
            "choose another spectrum",
        )
    result = behind(found.x)
    rate = panel_rate(scene, result, target.panel)[CHANNELS.index(target.channel)]
    intensity = lamp.intensity_w_per_sr * target.rate_e_per_s / float(rate)
    return dataclasses.replace(result, intensity_w_per_sr=intensity)
