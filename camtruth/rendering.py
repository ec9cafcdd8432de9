"""Light to rate images, lamp by lamp."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext

from camtruth.options import SAMPLES
from render import path_traced
from render.batches import BATCHES
from render.rate import RateImage
from scenes import scene as scenes
from scenes.scene import Scene

Advance = Callable[[int], None]
Watch = Callable[[str, int], AbstractContextManager[Advance]]
"""Shows progress: given a description and a number of parts, told of each part as it is done."""


def _unwatched(what: str, parts: int) -> AbstractContextManager[Advance]:
    return nullcontext(lambda done: None)


def render(
    scene: Scene | str = "chart",
    lamps: Sequence[str] | None = None,
    *,
    noise: float | None = None,
    samples: int = SAMPLES,
    seed: int = 0,
    bounces: int = 0,
    watch: Watch = _unwatched,
) -> dict[str, RateImage]:
    """Render a scene under each lamp by itself: photo-electrons per second at lamp level 1.

    Args:
        scene: a scene, a preset's name or the path of a TOML file.
        lamps: names of its lamps; all by default.
        noise: relative standard error to reach inside every panel, with more samples if needed.
        samples: light paths per pixel.
        seed: seed of the light paths.
        bounces: how often light may be thrown back before it reaches a panel; 0 is direct light.
        watch: shows progress.

    Raises:
        InputError: for an unknown scene or lamp, or one that cannot be rendered.
    """
    scene = scenes.load(scene) if isinstance(scene, str) else scene
    chosen = [scene.named(name) for name in (scene.lamp_names if lamps is None else lamps)]
    images = {}
    for lamp in chosen:
        what = f"rendering '{scene.name}' under the {lamp.name} lamp"
        with watch(what, BATCHES) as advance:
            images[lamp.name] = path_traced.render(
                scene,
                lamp,
                noise=noise,
                samples=samples,
                seed=seed,
                bounces=bounces,
                progress=_each(advance),
            )
    return images


def _each(advance: Advance) -> Callable[[int, int], None]:
    return lambda done, expected: advance(1)
