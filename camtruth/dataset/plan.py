"""From a specification to its pieces: images of the light, and shards.

A shard is a capture folder: one body of one camera at one focus with one variant of effects, all
shots. Its name says which, and its seeds follow from the name and the specification's seed, so a
shard is the same whoever makes it, alone or among thousands.
"""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camtruth.dataset.spec import Spec
from foundation.errors import DocumentError, InputError, unknown
from scenes import scene as scenes
from scenes.check import refuse_impossible
from scenes.scene import Scene
from sensor import camera_file
from sensor.camera import Camera
from sensor.protocol import Protocol, Shot
from sensor.stream import key_of

LIGHT = "light"
SPLITS = ("train", "test")


@dataclass(frozen=True, kw_only=True)
class Light:
    """A rate image to be made: a lamp, a focus and an image size."""

    lamp: str
    focus: int
    width: int
    height: int

    @property
    def name(self) -> str:
        """Its file below the folder of lights."""
        return f"{LIGHT}/{self.lamp}-f{self.focus}-{self.width}x{self.height}.exr"


@dataclass(frozen=True, kw_only=True)
class Shard:
    """A capture to be taken.

    Attributes:
        camera, focus, effects: positions in the lists of the specification.
        body: number of the camera body.
        split: train or test.
        name: its folder.
    """

    camera: int
    body: int
    focus: int
    effects: int
    split: str
    name: str

    @property
    def path(self) -> str:
        """Its folder below that of the dataset."""
        return f"{self.split}/{self.name}"


@dataclass(frozen=True, kw_only=True)
class Plan:
    """All that is to be made, in order."""

    spec: Spec
    lights: tuple[Light, ...]
    shards: tuple[Shard, ...]
    protocol: Protocol

    @property
    def frames(self) -> int:
        """Frames of the whole dataset."""
        return len(self.shards) * sum(shot.frames for shot in self.protocol.shot)


def plan(spec: Spec) -> Plan:
    """The pieces of a dataset, everything they name proved to exist.

    Raises:
        InputError: for an unknown camera, lamp, effect or scene.
    """
    names = [_short(name) for name in spec.cameras]
    for name in names:
        if names.count(name) > 1:
            raise DocumentError(
                f"two cameras are called '{name}'", "expected each once", "rename a file"
            )
    foci = range(max(1, len(spec.focus_distances_m)))
    sizes = []
    for camera in range(len(spec.cameras)):
        for variant in range(len(spec.effects)):
            body = camera_of(spec, camera, variant)
        sizes.append((body.width, body.height))
    for focus in foci:
        scene_of(spec, focus, *sizes[0])
    lights = [
        Light(lamp=lamp, focus=focus, width=width, height=height)
        for lamp in spec.lamps
        for focus in foci
        for width, height in dict.fromkeys(sizes)
    ]
    shards = []
    for camera, name in enumerate(names):
        test = test_bodies(spec, name)
        shards += [
            Shard(
                camera=camera,
                body=body,
                focus=focus,
                effects=variant,
                split=SPLITS[body in test],
                name=f"{name}-b{body:05d}-f{focus}-e{variant}",
            )
            for body in range(spec.bodies)
            for focus in foci
            for variant in range(len(spec.effects))
        ]
    return Plan(spec=spec, lights=tuple(lights), shards=tuple(shards), protocol=protocol_of(spec))


def _short(camera: str) -> str:
    stem = Path(camera).stem if camera.endswith(".toml") else camera
    return "".join(c if c.isalnum() else "-" for c in stem)


def test_bodies(spec: Spec, camera: str) -> set[int]:
    """The bodies of a camera in the test split: those of the smallest keys."""
    order = sorted(range(spec.bodies), key=lambda body: key_of("split", spec.seed, camera, body))
    return set(order[: spec.test_bodies])


@functools.lru_cache(maxsize=1024)
def camera_of(spec: Spec, camera: int, variant: int) -> Camera:
    """A camera with a variant of effects, of no body in particular."""
    made = camera_file.load(spec.cameras[camera])
    for setting in spec.effects[variant]:
        made = camera_file.with_setting(made, setting)
    if spec.size is not None:
        made = made.resized(spec.size[1], spec.size[0])
    return made


def body_of(spec: Spec, shard: Shard) -> Camera:
    """The camera body that a shard is taken with."""
    seed = key_of("body", spec.seed, _short(spec.cameras[shard.camera]), shard.body) % 2**63
    return camera_of(spec, shard.camera, shard.effects).with_body(seed)


def seed_of(spec: Spec, shard: Shard) -> int:
    """Seed of what is drawn anew in every frame of a shard."""
    return key_of("frames", spec.seed, shard.name) % 2**63


def scene_of(spec: Spec, focus: int, width: int, height: int) -> Scene:
    """The scene at a focus and an image size.

    Raises:
        InputError: for an unknown scene or lamp, or a focus that the lens cannot have.
    """
    scene = scenes.load(spec.scene).with_size(width, height)
    for lamp in spec.lamps:
        if lamp not in scene.lamp_names:
            raise unknown("lamp", lamp, scene.lamp_names, InputError)
    if spec.focus_distances_m:
        lens = dataclasses.replace(scene.lens, focus_distance_m=spec.focus_distances_m[focus])
        scene = dataclasses.replace(scene, lens=lens)
        refuse_impossible(scene)
    return scene


def protocol_of(spec: Spec) -> Protocol:
    """The shots of every shard: each exposure in the dark, then every lamp, level and exposure."""
    shots = [
        Shot(label=f"dark-{_ms(exposure)}", exposure_s=exposure, frames=spec.frames)
        for exposure in spec.exposures_s
    ]
    shots += [
        Shot(
            label=f"{lamp}-{level:g}-{_ms(exposure)}",
            light=(lamp,),
            level=(level,),
            exposure_s=exposure,
            frames=spec.frames,
        )
        for lamp in spec.lamps
        for level in spec.levels
        for exposure in spec.exposures_s
    ]
    return Protocol(name=spec.name, shot=tuple(shots))


def _ms(exposure_s: float) -> str:
    return f"{1e3 * exposure_s:g}ms"


def rows(made: Plan) -> list[dict[str, Any]]:
    """The dataset's table: a row for every stack of frames."""
    spec = made.spec
    table = []
    for shard in made.shards:
        body = body_of(spec, shard)
        for shot in made.protocol.shot:
            light = Light(
                lamp=shot.light[0], focus=shard.focus, width=body.width, height=body.height
            )
            focus = spec.focus_distances_m[shard.focus] if spec.focus_distances_m else ""
            table.append(
                {
                    "file": f"{shard.path}/{shot.label}.npy",
                    "split": shard.split,
                    "camera": body.name,
                    "body_seed": body.body_seed,
                    "effects": " ".join(spec.effects[shard.effects]),
                    "focus_distance_m": focus,
                    "lamp": shot.light[0],
                    "level": shot.level[0],
                    "exposure_s": shot.exposure_s,
                    "frames": shot.frames,
                    "light": "" if shot.dark else light.name,
                    "truth": f"{shard.path}/truth.json",
                }
            )
    return table
