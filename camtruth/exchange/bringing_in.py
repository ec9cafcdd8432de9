"""Frames of other programs and real cameras to a capture folder.

capture.toml          as any capture
LABEL.npy             the frames of each shot, as they were, or shifted to the right
import.json           where every figure came from, and the checksum of every file read
panels.png            the panels over a picture, to check
truth.json, *.exr     where what was imported is an export of a simulated capture
"""

from __future__ import annotations

import dataclasses
import json
import shutil
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from camtruth.exchange import panels as charts
from camtruth.exchange.answers import (
    Answers,
    Settled,
    bits_of,
    camera_of,
    mosaic_of,
    settle,
)
from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.export import SHOTS, SHOTS_FORMAT
from camtruth.exchange.question import question
from camtruth.exchange.reels import Reel, discovered, named
from camtruth.exchange.stack_writer import Written, stack_once
from foundation.documents import convert, read_text
from foundation.errors import DocumentError
from foundation.output import sha256
from foundation.panel import Panel
from sensor.capture_folder import (
    FORMAT,
    MANIFEST,
    TRUTH,
    CaptureDocument,
    ShotDocument,
    inside,
    read_capture,
    write_manifest,
)
from sensor.frames import Pixels
from sensor.protocol import DARK

RECORD = "import.json"
OVERLAY = "panels.png"
CHART, NONE = "chart", "none"
LOOKED_AT = 8
"""Frames that are averaged to find the chart in."""

Progress = Callable[[int], None]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Found:
    """What lies in a folder to import: shots, a manifest if there is one, files left aside."""

    reels: tuple[Reel, ...]
    manifest: CaptureDocument | None
    aside: tuple[Path, ...]


@dataclasses.dataclass(frozen=True, kw_only=True)
class BroughtIn:
    """What was imported, and how many of the shots stood there already."""

    frames: int
    shots: int
    kept: int
    pixels: str
    bits: int
    panels: int
    notes: tuple[str, ...]


def look(folder: Path, shots: Path | None = None) -> Found:
    """What lies in a folder: by its `shots.toml` or `capture.toml`, or by its files.

    Raises:
        InputError: when there are no frames, or the manifest is none.
    """
    manifests = [shots] if shots else [folder / SHOTS, folder / MANIFEST]
    path = next((each for each in manifests if shots or each.is_file()), None)
    if path is None:
        reels, aside = discovered(folder)
        return Found(reels=tuple(reels), manifest=None, aside=tuple(aside))
    if not folder.is_dir():
        raise ExchangeError(f"no folder {folder}", "expected one with frames", "check the path")
    document = _manifest(path)
    return Found(
        reels=tuple(named(folder, entry.label, entry.frames) for entry in document.shot),
        manifest=document,
        aside=(),
    )


def _manifest(path: Path) -> CaptureDocument:
    """A manifest of shots: that of a capture folder, or of an export."""
    try:
        data = tomllib.loads(read_text(path))
    except (tomllib.TOMLDecodeError, RecursionError) as problem:
        raise DocumentError(
            f"{path} is not TOML ({problem})", "expected valid TOML", "correct that line"
        ) from None
    if data.get("format") == SHOTS_FORMAT:
        data["format"] = FORMAT
    return convert(data, CaptureDocument, str(path))


def with_manifest(answers: Answers, manifest: CaptureDocument | None) -> Answers:
    """What the user says, and where he says nothing what the manifest says."""
    if manifest is None:
        return answers
    grey = manifest.pixels.startswith("mono")
    return dataclasses.replace(
        answers,
        camera=answers.camera or manifest.camera,
        bits=answers.bits or manifest.bits,
        cfa=answers.cfa or manifest.cfa or ("none" if grey else None),
        shots={shot.label: shot for shot in manifest.shot},
    )


def asked(folder: Path, found: Found, answers: Answers, panels: str, given: Sequence[Panel]) -> str:
    """What decides the bytes of an import, as text; see `foundation.resumable`."""
    said = {"import": dataclasses.asdict(answers), "panels": panels, "given": list(given)}
    files = [file for reel in found.reels for file in reel.files]
    rates = [shot.rate for shot in (found.manifest.shot if found.manifest else ()) if shot.rate]
    return question(said, [*files, *(inside(folder, name) for name in (TRUTH, *rates))])


def bring_in(
    out: Path,
    folder: Path,
    found: Found,
    answers: Answers,
    *,
    panels: str = NONE,
    given: Sequence[Panel] = (),
    progress: Progress = lambda frames: None,
) -> BroughtIn:
    """Write a capture into a folder, or what is missing of it; see `foundation.resumable`.

    Args:
        out: the folder; shots that stand there are done.
        folder: what is imported; see `look`.
        found: what lies in it.
        answers: what the user and the manifest say; see `with_manifest`.
        panels: "chart" to find them, "none".
        given: panels that are given.
        progress: told the number of frames done.

    Raises:
        InputError: for what is not known, differs, or is damaged.
    """
    settled, notes = settle(found.reels, answers)
    camera = camera_of(found.reels, answers)
    written = []
    for shot in settled:
        made = stack_once(
            out / f"{shot.reel.label}.npy", shot.reel.label, shot.reel.frames(), answers.shift or 0
        )
        written.append(made)
        progress(made.count)
    told = [reel.told for reel in found.reels]
    colour, sample_bits = _one_kind(settled, written)
    cfa = mosaic_of(told, colour, answers)
    bits = bits_of(told, sample_bits, answers)
    _check_bits(written, bits, answers.shift, sample_bits)
    pixels: Pixels = "rgb8"
    if not colour:
        pixels = f"{'bayer' if cfa else 'mono'}{sample_bits}"  # type: ignore[assignment]
    notes += [f"shot '{r.label}': {r.told.conversion}" for r in found.reels if r.told.conversion]
    notes += [f"left aside: {path.relative_to(folder)}" for path in found.aside]
    scene = found.manifest.scene if found.manifest else None
    document = CaptureDocument(
        format=FORMAT,
        camera=camera,
        pixels=pixels,
        bits=bits,
        cfa=cfa,
        scene=scene,
        shot=tuple(_shot(shot, answers.shots.get(shot.reel.label)) for shot in settled),
        panel=_panels(out, settled, cfa, panels, given, found.manifest),
    )
    write_manifest(out, document)
    _copy_truth(out, folder, document)
    capture = read_capture(out)
    record = _record(folder, found, settled, answers, notes, document)
    (out / RECORD).write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return BroughtIn(
        frames=sum(made.count for made in written),
        shots=len(settled),
        kept=sum(made.kept for made in written),
        pixels=pixels,
        bits=bits,
        panels=len(capture.panels),
        notes=tuple(notes),
    )


def _one_kind(settled: Sequence[Settled], written: Sequence[Written]) -> tuple[bool, int]:
    first = written[0]
    for shot, made in zip(settled, written, strict=True):
        if (made.shape, made.sample_bits) != (first.shape, first.sample_bits):
            raise ExchangeError(
                f"shot '{shot.reel.label}' has frames {made.shape} of {made.sample_bits} bits",
                f"expected {first.shape} of {first.sample_bits} as shot '{settled[0].reel.label}'",
                "import frames of one size and kind together",
            )
    colour = len(first.shape) == 3
    if len(first.shape) not in (2, 3) or (colour and first.shape[2] != 3):
        raise ExchangeError(
            f"frames of shape {first.shape}", "expected (H, W) or (H, W, 3)", "convert them"
        )
    if colour and first.sample_bits != 8:
        raise ExchangeError(
            "colour frames of 16 bits",
            "expected 8-bit RGB, or raw or grey frames",
            "import the raw files, or convert to 8 bits",
        )
    return colour, first.sample_bits


def _check_bits(written: Sequence[Written], bits: int, shift: int | None, sample_bits: int) -> None:
    """Samples must stand at the right: neither above the bits, nor all multiples of 2, 4, ..."""
    used = 0
    for made in written:
        used |= made.bits_used
    if bits > sample_bits or used >= 2**bits:
        raise ExchangeError(
            f"samples of up to {used.bit_length()} bits in {sample_bits}",
            f"expected at most {bits} used",
            "pass another --bits, or shift them to the right by --shift",
        )
    empty = (used & -used).bit_length() - 1 if used else 0
    if empty and shift is None:
        raise ExchangeError(
            f"the lowest {empty} bits of every sample are 0",
            "expected samples that stand at the right",
            f"pass --shift {empty}, or --shift 0 if that is what the camera gives",
        )


def _shot(shot: Settled, stated: ShotDocument | None) -> ShotDocument:
    return ShotDocument(
        label=shot.reel.label,
        light=shot.light.lamps,
        level=shot.light.levels,
        exposure_s=shot.exposure_s,
        frames=f"{shot.reel.label}.npy",
        rate=stated.rate if stated else None,
        interval_s=shot.interval_s,
        temperature_c=shot.temperature_c,
    )


def _panels(
    out: Path,
    settled: Sequence[Settled],
    cfa: str | None,
    wanted: str,
    given: Sequence[Panel],
    manifest: CaptureDocument | None,
) -> tuple[Panel, ...]:
    """The panels given, found or in the manifest; drawn over a picture wherever there are any."""
    stated = tuple(given) or (manifest.panel if manifest else ())
    if wanted == NONE and not stated:
        return ()
    stacks = {
        shot.reel.label: np.load(out / f"{shot.reel.label}.npy", mmap_mode="r")
        for shot in settled
        if shot.light.lamps != (DARK,)
    } or {s.reel.label: np.load(out / f"{s.reel.label}.npy", mmap_mode="r") for s in settled}
    brightest = max(stacks.values(), key=lambda stack: float(stack[0].mean()))
    scale = 2 if cfa is not None and brightest.ndim == 3 else 1
    shown = charts.picture(brightest[:LOOKED_AT], cfa)
    panels = charts.detect(shown, scale) if wanted == CHART else stated
    charts.overlay(out / OVERLAY, shown, panels, scale)
    return panels


def _copy_truth(out: Path, folder: Path, document: CaptureDocument) -> None:
    """Rate images and truth record, where the folder is an export of a simulated capture."""
    names = {shot.rate for shot in document.shot if shot.rate is not None}
    if (folder / TRUTH).is_file():
        names.add(TRUTH)
    for name in sorted(names):
        source = inside(folder, name)
        if not source.is_file():
            raise ExchangeError(f"no file {source}", "expected it", "remove 'rate' or add the file")
        target = inside(out, name)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)


def _record(
    folder: Path,
    found: Found,
    settled: Sequence[Settled],
    answers: Answers,
    notes: Sequence[str],
    document: CaptureDocument,
) -> dict[str, Any]:
    return {
        "format": "camtruth-import/1",
        "shift": answers.shift or 0,
        "notes": list(notes),
        "shots": [
            {
                "label": shot.reel.label,
                "said_by": dict(shot.sources),
                "header": {k: v for k, v in vars(shot.reel.told).items() if v is not None},
                "files": [
                    {"name": path.relative_to(folder.resolve()).as_posix(), "sha256": sha256(path)}
                    for path in (each.resolve() for each in shot.reel.files)
                    if path.is_file()
                ],
            }
            for shot in settled
        ],
    }
