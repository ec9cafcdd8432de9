"""A capture in another program's format, with all that is known of it beside the frames.

    frames/          the frames, in the format asked for
    frames.csv       a row for each: file, place in it, shot, light, level, exposure
    truth.json       parameters with units, seeds, versions; noise figures per channel
    rate-LAMP.exr    the light, electrons per second
    truth/           per pixel: mean electrons of each shot, response, offset; .npy
    capture.toml     or shots.toml where the frames must be imported to be a capture again
    README.md, LICENSE.txt, croissant.json, SHA256SUMS

The bytes depend on the capture, the format and the versions of the writers, not on the day.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import re
from collections.abc import Callable, Iterable
from importlib.metadata import version
from pathlib import Path

from camtruth.exchange.card import CARD, card, licence_url
from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.format import Format, FrameFile, format_named
from camtruth.exchange.question import question
from camtruth.exchange.readme import readme
from camtruth.exchange.source import Source, read_source
from camtruth.exchange.truth_maps import Map, truth_maps
from foundation.jobs import fingerprint
from sensor.capture_folder import FORMAT, MANIFEST, TRUTH, write_manifest

FRAMES = "frames"
TABLE = "frames.csv"
README = "README.md"
LICENCE = "LICENSE.txt"
SHOTS = "shots.toml"
SHOTS_FORMAT = "camtruth-shots/1"

COLUMNS = {
    "file": "Text",
    "index": "Integer",
    "shot": "Text",
    "frame": "Integer",
    "light": "Text",
    "level": "Text",
    "exposure_s": "Float",
    "interval_s": "Float",
    "temperature_c": "Float",
}

SIMULATED_LICENCE = "CC0-1.0"
"""Nobody has a right in numbers that a program drew; who exports them may say otherwise."""

SPDX = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]{0,99}")

Progress = Callable[[int], None]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Exported:
    """What was written, and how many of the files of frames stood there already."""

    frames: int
    files: int
    kept: int
    maps: tuple[str, ...]


def prepare(folder: Path, format_name: str, licence: str | None) -> tuple[Source, Format, str]:
    """Check what is asked before anything is written.

    Raises:
        InputError: for a folder that is no capture, an unknown format, pixels that it cannot hold,
            or a real capture without a licence.
    """
    chosen = format_named(format_name)
    source = read_source(folder)
    chosen.refuse_pixels(source)
    if licence is None and source.truth is None:
        raise ExchangeError(
            f"{folder} is not known to be simulated, and has no licence",
            "expected to be told under which others may use it",
            "pass --licence with an SPDX identifier, as in --licence CC-BY-4.0",
        )
    licence = licence or SIMULATED_LICENCE
    if not SPDX.fullmatch(licence):
        raise ExchangeError(
            f"licence '{licence}'", "expected an SPDX identifier", "as in --licence CC-BY-4.0"
        )
    return source, chosen, licence


def asked(source: Source, chosen: Format, licence: str) -> str:
    """What decides the bytes of an export, as text; see `foundation.resumable`."""
    options = {"export": chosen.name, "licence": licence, "by": fingerprint()}
    return question(options, source.files)


def export(
    out: Path,
    source: Source,
    chosen: Format,
    licence: str,
    *,
    progress: Progress = lambda frames: None,
) -> Exported:
    """Write a capture into a folder, or what is missing of it; see `foundation.resumable`."""
    home = out / FRAMES
    home.mkdir(exist_ok=True)
    written = []
    for file in chosen.write(home, source):
        written.append(file)
        progress(file.count)
    maps = []
    for known in truth_maps(source):
        known.write(out)
        maps.append(dataclasses.replace(known, values=known.values[:0]))
    for name in [*source.rate_files.values(), *([TRUTH] if source.truth else [])]:
        source.copy(name, out)
    (out / TABLE).write_text(_table(source, written), encoding="utf-8")
    _write_shots(out, source, chosen)
    about = f"SPDX-License-Identifier: {licence}\n{licence_url(licence)}\n"
    (out / LICENCE).write_text(about, encoding="utf-8")
    (out / README).write_text(readme(source, chosen, maps, licence), encoding="utf-8")
    (out / CARD).write_text(_card(out, source, chosen, maps, licence), encoding="utf-8")
    return Exported(
        frames=sum(file.count for file in written),
        files=len(written),
        kept=sum(file.kept for file in written),
        maps=tuple(known.file for known in maps),
    )


def _table(source: Source, written: Iterable[FrameFile]) -> str:
    shots = {document.label: document for document, _ in source.shots}
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for file in written:
        shot = shots[file.shot]
        told = (
            " ".join(shot.light),
            " ".join(f"{level:g}" for level in shot.level),
            shot.exposure_s,
            "" if shot.interval_s is None else shot.interval_s,
            "" if shot.temperature_c is None else shot.temperature_c,
        )
        for index in range(file.count):
            rows.writerow((f"{FRAMES}/{file.name}", index, file.shot, file.first + index, *told))
    return text.getvalue()


def _write_shots(out: Path, source: Source, chosen: Format) -> None:
    """The manifest: a capture folder's where that can hold the files, else one for the import."""
    if chosen.stack is None:
        return
    document = dataclasses.replace(
        source.document,
        format=FORMAT if chosen.native else SHOTS_FORMAT,
        shot=tuple(
            dataclasses.replace(shot, frames=f"{FRAMES}/{chosen.stack.format(label=shot.label)}")
            for shot in source.document.shot
        ),
    )
    write_manifest(out, document)
    if not chosen.native:
        (out / MANIFEST).rename(out / SHOTS)


def _card(out: Path, source: Source, chosen: Format, maps: list[Map], licence: str) -> str:
    camera = source.document.camera
    sets = [(FRAMES, f"{FRAMES}/**", chosen.media_type)]
    if maps:
        sets.append(("truth", "truth/*.npy", "application/octet-stream"))
    document = card(
        out,
        name=f"camtruth-{re.sub('[^A-Za-z0-9]+', '-', camera).strip('-').lower()}-{chosen.name}",
        description=(
            f"Frames of camera '{camera}' as {chosen.says}"
            + (", simulated; every noise is known." if source.truth else ".")
        ),
        licence=licence,
        version=version("camtruth"),
        tables={"frame_table": (TABLE, COLUMNS)},
        frames=sets,
    )
    return json.dumps(document, indent=1, allow_nan=False) + "\n"
