"""What a dataset is to hold, as a TOML file says it: every combination of its lists.

format = "camtruth-dataset/1"
name = "two cameras under two lamps"
seed = 1
cameras = ["i400", "my_camera.toml"]
bodies = 10                       # of each camera, with fixed patterns of their own
test_bodies = 2                   # of them for the test split, drawn by the seed
lamps = ["incandescent", "fluorescent"]
levels = [0.25, 0.5, 1.0]
exposures_s = [0.008, 0.03268]    # each also in the dark
focus_distances_m = [0.18, 0.3]   # of the lens: defocus; left out, that of the scene
effects = [[], ["row_noise.sigma_e=12"]]   # settings added to the camera, variant by variant
frames = 16                       # of each shot
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from foundation.documents import STRICT, read_toml, spelt
from foundation.errors import DocumentError

FORMAT = "camtruth-dataset/1"

Positive = Annotated[float, Field(gt=0, le=1e5)]
Level = Annotated[float, Field(ge=0, le=1e6)]
Text = Annotated[str, Field(min_length=1, max_length=200)]
MOST = 10_000_000
"""Shards, and frames of a shot, beyond which a number is a slip of the finger."""


@dataclass(frozen=True, kw_only=True)
class Spec:
    """A dataset's specification; see the top of this file.

    Attributes:
        renderer: "path-traced", or "closed-form", which is instant and right inside panels alone.
        samples: light paths per pixel.
        size: width and height in pixels in place of the cameras' own, to try things out.
        licence: SPDX identifier.
    """

    format: Annotated[str, Field(pattern=f"^{FORMAT}$")]
    name: Text
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    cameras: Annotated[tuple[Text, ...], Field(min_length=1)]
    bodies: Annotated[int, Field(ge=1, le=MOST)] = 1
    test_bodies: Annotated[int, Field(ge=0, le=MOST)] = 0
    scene: Text = "chart"
    lamps: Annotated[tuple[Text, ...], Field(min_length=1)]
    levels: Annotated[tuple[Level, ...], Field(min_length=1)]
    exposures_s: Annotated[tuple[Positive, ...], Field(min_length=1)]
    focus_distances_m: tuple[Positive, ...] = ()
    effects: Annotated[tuple[tuple[Text, ...], ...], Field(min_length=1)] = ((),)
    frames: Annotated[int, Field(ge=1, le=MOST)] = 16
    renderer: Literal["path-traced", "closed-form"] = "path-traced"
    samples: Annotated[int, Field(ge=1, le=1_000_000)] = 128
    size: (
        tuple[Annotated[int, Field(ge=8, le=8192)], Annotated[int, Field(ge=8, le=8192)]] | None
    ) = None
    licence: Annotated[str, spelt(r"[A-Za-z0-9][A-Za-z0-9.+-]{0,99}", "an SPDX identifier")] = (
        "CC0-1.0"
    )

    __pydantic_config__ = STRICT


def read_spec(path: Path) -> Spec:
    """A specification, checked as far as it can be by itself.

    Raises:
        DocumentError: when the file is none, or asks for what cannot be.
    """
    spec = read_toml(path, Spec)
    for key in ("cameras", "lamps", "levels", "exposures_s", "focus_distances_m", "effects"):
        values = list(getattr(spec, key))
        again = [value for value in values if values.count(value) > 1]
        if again:
            raise DocumentError(
                f"{key} holds {again[0]!r} twice in {path}", "expected each once", "remove one"
            )
    if spec.test_bodies > spec.bodies:
        raise DocumentError(
            f"test_bodies = {spec.test_bodies} of {spec.bodies} bodies in {path}",
            "expected no more than there are",
            "correct test_bodies",
        )
    return spec
