"""A dataset from its specification: light first, then shards, then what describes them.

train/CAMERA-BODY-FOCUS-EFFECTS/   shards: capture folders with their truth
test/...                           the same of camera bodies that train/ never saw
light/                             rate images, electrons per second
shards.csv                         a row for each stack of frames
dataset.toml                       the specification
README.md, LICENSE.txt, croissant.json, SHA256SUMS
"""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import tomli_w

from camtruth.dataset.pieces import Place, make_light, make_shard
from camtruth.dataset.plan import LIGHT, SPLITS, Plan, rows
from camtruth.dataset.spec import Spec
from camtruth.exchange.card import CARD, card, licence_url
from foundation.jobs import fingerprint, run
from foundation.resumable import resumable_folder

TABLE = "shards.csv"
SPECIFICATION = "dataset.toml"
README = "README.md"
LICENCE = "LICENSE.txt"

COLUMNS = {
    "file": "Text",
    "split": "Text",
    "camera": "Text",
    "body_seed": "Integer",
    "effects": "Text",
    "focus_distance_m": "Float",
    "lamp": "Text",
    "level": "Float",
    "exposure_s": "Float",
    "frames": "Integer",
    "light": "Text",
    "truth": "Text",
}

Progress = Callable[[int], None]


@dataclass(frozen=True, kw_only=True)
class Made:
    """What was made, and how much of it stood there already."""

    shards: int
    frames: int
    kept: int


def make(
    out: Path,
    planned: Plan,
    *,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    threads: int | None = None,
    progress: Progress = lambda frames: None,
) -> Made:
    """Make a dataset, or what is missing of it.

    Args:
        out: its folder; filled as ``out.unfinished``, which a later run can go on with.
        planned: what to make.
        resume: go on with an unfinished run.
        overwrite: replace what stands there.
        scheduler: address of a Dask scheduler whose workers see `out` at the same path.
        threads: shards at once in this process.
        progress: told the number of frames done.

    Raises:
        InputError: when the place is taken or cannot be written, or a worker fails.
    """
    spec = planned.spec
    question = json.dumps([dataclasses.asdict(spec), fingerprint()], sort_keys=True)
    with resumable_folder(out, question, resume=resume, overwrite=overwrite) as folder:
        for name in (LIGHT, *SPLITS):
            (folder / name).mkdir(exist_ok=True)
        place = Place(spec=spec, folder=str(folder.resolve()))
        run(
            make_light,
            {light.name: light for light in planned.lights},
            shared=place,
            scheduler=scheduler,
            threads=1,  # a renderer takes all cores by itself
        )
        per_shard = sum(shot.frames for shot in planned.protocol.shot)
        missing = {s.path: s for s in planned.shards if not (folder / s.path).exists()}
        kept = len(planned.shards) - len(missing)
        progress(kept * per_shard)
        run(
            make_shard,
            missing,
            shared=place,
            scheduler=scheduler,
            threads=threads,
            progress=lambda shards: progress(shards * per_shard),
        )
        describe(folder, planned)
    return Made(shards=len(planned.shards), frames=planned.frames, kept=kept)


def describe(folder: Path, planned: Plan) -> None:
    """Write what a reader needs besides the shards."""
    spec = planned.spec
    text = io.StringIO()
    table = csv.DictWriter(text, list(COLUMNS), lineterminator="\n")
    table.writeheader()
    table.writerows(rows(planned))
    _write(folder / TABLE, text.getvalue())
    _write(folder / SPECIFICATION, _toml(spec))
    _write(
        folder / LICENCE,
        f"SPDX-License-Identifier: {spec.licence}\n{licence_url(spec.licence)}\n",
    )
    _write(folder / README, _readme(planned))
    document = card(
        folder,
        name=spec.name,
        description=_about(planned),
        licence=spec.licence,
        version=version("camtruth"),
        tables={"stacks": (TABLE, COLUMNS)},
        frames=[(split, f"{split}/**/*.npy", "application/octet-stream") for split in SPLITS]
        + [(LIGHT, f"{LIGHT}/*.exr", "image/x-exr")],
    )
    _write(folder / CARD, json.dumps(document, indent=1, allow_nan=False) + "\n")


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _toml(spec: Spec) -> str:
    known = {k: v for k, v in dataclasses.asdict(spec).items() if v is not None and v != ()}
    return tomli_w.dumps(json.loads(json.dumps(known)))


def _about(planned: Plan) -> str:
    return (
        f"{planned.frames} simulated frames in {len(planned.shards)} shards with every noise"
        " known; train and test differ in camera bodies."
    )


def _readme(planned: Plan) -> str:
    return f"""# {planned.spec.name}

{_about(planned)}

Each folder below `train/` and `test/` is a shard: one camera body, one focus, one variant of
effects, all shots. `shards.csv` has a row for each stack of frames:

    import csv, numpy
    for row in csv.DictReader(open("shards.csv")):
        frames = numpy.load(row["file"], mmap_mode="r", allow_pickle=False)

`truth.json` of a shard states every effect with its parameters and units, the seeds, and what an
ideal estimator would find. `light/*.exr` holds photo-electrons per second at lamp level 1.

Check it with `sha256sum --check SHA256SUMS`, or `camtruth verify`. The same `dataset.toml` and
versions give the same bytes. Licence: {planned.spec.licence}, see LICENSE.txt.
"""
