"""Making one piece of a dataset: an image of the light, or a shard. Pure functions of their case.

Each piece is written whole or not at all, so one that stands there is done.
"""

from __future__ import annotations

import dataclasses
import functools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camtruth.dataset.plan import Light, Shard, body_of, protocol_of, scene_of, seed_of
from camtruth.dataset.spec import Spec
from foundation.errors import OutputError
from foundation.output import new_folder
from render.rate import RateImage, read_rate, write_rate
from sensor.capture_folder import TRUTH, write_capture
from sensor.stream import key_of
from sensor.truth import truth


@dataclass(frozen=True, kw_only=True)
class Place:
    """What all pieces share: the specification, and the folder that every worker can see."""

    spec: Spec
    folder: str


def make_light(place: Place, light: Light) -> str:
    """Render a lamp's rate image, unless it is there."""
    path = Path(place.folder) / light.name
    _refuse_unseen(path.parent)
    if path.exists():
        return light.name
    scene = scene_of(place.spec, light.focus, light.width, light.height)
    if place.spec.renderer == "closed-form":
        from render import closed_form

        image = closed_form.render(scene, light.lamp)
    else:
        from render import path_traced

        seed = key_of("light", place.spec.seed, light.name) % 2**31
        lamp = scene.named(light.lamp)
        image = path_traced.render(scene, lamp, samples=place.spec.samples, seed=seed)
    write_rate(path, image)
    return light.name


def make_shard(place: Place, shard: Shard) -> str:
    """Take a shard's shots, unless it is there."""
    path = Path(place.folder) / shard.path
    _refuse_unseen(path.parent)
    if path.exists():
        return shard.path
    spec = place.spec
    body = body_of(spec, shard)
    lights = {
        lamp: Light(lamp=lamp, focus=shard.focus, width=body.width, height=body.height)
        for lamp in spec.lamps
    }
    images = {lamp: _rate(f"{place.folder}/{light.name}") for lamp, light in lights.items()}
    protocol = protocol_of(spec)
    seed = seed_of(spec, shard)
    try:
        with new_folder(path) as folder:
            write_capture(
                folder,
                body,
                protocol,
                {lamp: image.rate_e_per_s for lamp, image in images.items()},
                seed=seed,
                scene=spec.scene,
                panels=next(iter(images.values())).header.panels,
            )
            document = truth(body, protocol, seed, light=_known(lights, images))
            (folder / TRUTH).write_text(
                json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8"
            )
    except OutputError:
        # A worker that was given up for dead may have made the same shard meanwhile.
        if not path.exists():
            raise
    return shard.path


def _known(lights: dict[str, Light], images: dict[str, RateImage]) -> dict[str, Any]:
    return {
        lamp: {**dataclasses.asdict(image.header), "file": lights[lamp].name}
        for lamp, image in images.items()
    }


@functools.lru_cache(maxsize=8)
def _rate(path: str) -> RateImage:
    """A rate image, kept for the next shards: a worker reads it once."""
    return read_rate(Path(path))


def _refuse_unseen(folder: Path) -> None:
    if not folder.is_dir():
        raise OutputError(
            f"a worker cannot see {folder}",
            "expected the dataset's folder at the same path on every machine",
            "choose an --out on a shared file system",
        )
