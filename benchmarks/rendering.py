"""Light paths per pixel to a relative noise of 5e-4 inside every panel, 640 x 480.

The plain way draws every path by itself: independent samples, a wavelength for each, and takes
batches as they come. Ours stratifies (multijitter), integrates over wavelength beforehand and
divides by a witness of the same random numbers; see docs/decisions/noise-of-the-render.md. The
noise of independent paths falls as one over the square root of their number, so the number needed
follows from what a few leave; ours is rendered with more and more paths until it is there.
"""

from __future__ import annotations

from collections.abc import Iterator

from render.path_traced import render
from scenes.scene import load

WANTED = 5e-4
FEW = 128
LADDER = (8, 32, 72, 128, 200, 288, 512)


def ratios() -> Iterator[tuple[str, float, float | None]]:
    scene = load("chart")
    for lamp in scene.lamp_names:
        plain = render(
            scene, lamp, samples=FEW, sampler="independent", wavelengths="sampled", witness=False
        ).header
        needed = plain.samples * (max(plain.noise.values()) / WANTED) ** 2
        for samples in LADDER:
            ours = render(scene, lamp, samples=samples).header
            if max(ours.noise.values()) <= WANTED:
                break
        what = (
            f"fewer samples a pixel to {WANTED:g} under the {lamp} lamp:"
            f" {ours.samples} multijitter against {needed:.3g} independent"
        )
        yield what, needed / ours.samples, 100
