"""A withheld set: its captures, and the seal.

Both folders grow beside their places and move there when they are whole, so that a run that was
stopped can go on. The secret and the truths that are known so far wait where the seal will be.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.report import FORMAT as GAP_FORMAT
from camtruth.blind.design import Wanted, body, design, exposed, nominal
from camtruth.blind.foreign.library import missing, outsiders
from camtruth.blind.format import (
    CASES,
    NOMINAL,
    SEAL_FORMAT,
    SET_FORMAT,
    TRUTH,
    CaseEntry,
    CaseTruth,
    SetDocument,
    TrueEffect,
    beside,
    write_set,
)
from camtruth.blind.ruler import NULLS, Ruler, make_ruler
from camtruth.blind.severity import Dressed, Probe, dressed_outside, dressed_own, own_effect
from camtruth.simulating import grey_panels, rates_of
from foundation.jobs import fingerprint, run
from foundation.output import new_folder, sha256
from foundation.panel import Panel
from foundation.resumable import resumable_folder
from render.rate import RateImage, write_rate
from sensor.camera import Camera
from sensor.camera_file import write as write_camera
from sensor.capture_folder import write_capture
from sensor.catalogue import effect as effect_of
from sensor.effect import Effect
from sensor.protocol import Protocol

SECRET = "secret"
JOURNAL = "truths.jsonl"
README = "README.md"

Progress = Callable[[int], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """What all cases share."""

    folder: str
    protocol: Protocol
    images: dict[str, RateImage]
    panels: tuple[Panel, ...]
    bases: dict[str, Camera]
    rulers: dict[str, Ruler]
    scene: str

    @property
    def rates(self) -> dict[str, NDArray[np.float32]]:
        """Photo-electrons per second by lamp."""
        return rates_of(self.images)


def make(
    out: Path,
    name: str,
    *,
    asked: Mapping[str, int],
    bases: Mapping[str, Camera],
    protocol: Protocol,
    images: Mapping[str, RateImage],
    scene: str,
    seed: int,
    nulls: int = NULLS,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    threads: int | None = None,
    progress: Progress = lambda cases: None,
) -> SetDocument:
    """Make a set at `out` and its seal beside it.

    Args:
        out: the set's folder.
        name: of the set.
        asked: number of cases by group; see `camtruth.blind.design.counts`.
        bases: presets that the cameras are like, at the size of the rate images.
        protocol: the shots.
        images: a rate image for each lamp.
        scene: its name.
        seed: decides the cases together with a secret that is drawn here.
        nulls: bodies that each ruler is made with.
        resume, overwrite: as everywhere.
        scheduler: of a cluster whose machines see `out` at the same path.
        threads: cases at once in this process.
        progress: told the number of cases done.

    Raises:
        InputError: when the place is taken, or something that is asked for cannot be had.
    """
    shapes = {lamp: image.rate_e_per_s.shape for lamp, image in images.items()}
    question = json.dumps(
        [
            *(name, dict(asked), sorted(bases), dataclasses.asdict(protocol), str(shapes)),
            *(scene, seed, nulls, fingerprint()),
        ]
    )
    with contextlib.ExitStack() as stack:
        folders = [
            stack.enter_context(
                resumable_folder(path, question, resume=resume, overwrite=overwrite)
            )
            for path in (beside(out, "seal"), out)
        ]
        seal, folder = folders
        secret = _secret(seal / SECRET)
        wanted = design(asked, bases, seed, secret)
        (folder / CASES).mkdir(exist_ok=True)
        rates = rates_of(images)
        bases = {base: exposed(camera, protocol, rates) for base, camera in bases.items()}
        place = Place(
            folder=str((folder / CASES).resolve()),
            protocol=protocol,
            images=dict(images),
            panels=grey_panels(images),
            bases=dict(bases),
            rulers={
                base: make_ruler(bases[base], protocol, rates, 1000, nulls=nulls)
                for base in sorted({case.base for case in wanted if case.targets})
            },
            scene=scene,
        )
        truths = run(
            make_case,
            {case.name: case for case in wanted},
            shared=place,
            scheduler=scheduler,
            threads=threads,
            journal=seal / JOURNAL,
            question=question,
            progress=progress,
        )
        _write_truth(seal, secret, seed, truths)
        document = SetDocument(
            format=SET_FORMAT,
            name=name,
            commitment=sha256(seal / TRUTH),
            missing_sources=missing() if asked.get("others") else (),
            case=tuple(CaseEntry(name=case.name, without=case.without) for case in wanted),
        )
        write_set(folder, document)
        (folder / README).write_text(_readme(document), encoding="utf-8")
    return document


def _secret(path: Path) -> bytes:
    """The secret of a run that goes on, or a new one, written before anything hangs on it."""
    if not path.exists():
        path.write_text(secrets.token_hex(32), encoding="utf-8")
        path.chmod(0o600)
    return bytes.fromhex(path.read_text(encoding="utf-8"))


def _write_truth(seal: Path, secret: bytes, seed: int, truths: Mapping[str, Any]) -> None:
    document = {
        "format": SEAL_FORMAT,
        "salt": secrets.token_hex(32),
        "secret": secret.hex(),
        "seed": seed,
        "cases": dict(truths),
    }
    path = seal / TRUTH
    path.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    path.chmod(0o600)
    for name in (SECRET, JOURNAL):
        (seal / name).unlink(missing_ok=True)


def make_case(place: Place, wanted: Wanted) -> dict[str, Any]:
    """Write a case's capture folder; its truth, as plain data."""
    plain = body(place.bases[wanted.base], wanted)
    camera, effects = dressed(place, wanted, plain)
    with new_folder(Path(place.folder) / wanted.name, overwrite=True) as folder:
        names = {lamp: f"rate-{lamp}.exr" for lamp in place.images}
        for lamp, image in place.images.items():
            write_rate(folder / names[lamp], image)
        write_capture(
            folder,
            camera,
            place.protocol,
            place.rates,
            seed=wanted.seed,
            scene=place.scene,
            panels=place.panels,
            rate_files=names,
        )
        write_camera(folder / NOMINAL, nominal(plain, wanted))
    truth = CaseTruth(
        group=wanted.group,
        camera=wanted.base,
        seed=wanted.seed,
        body_seed=wanted.body_seed,
        effects=effects,
        without=wanted.without,
        twin=wanted.twin,
        figures={
            "gain_dn_per_e": plain.gain_dn_per_e.plain(),
            "black_dn": plain.black_dn,
            **{effect.name: effect.values() for effect in plain.effects if effect.base},
        },
    )
    return dataclasses.asdict(truth)


def dressed(place: Place, wanted: Wanted, plain: Camera) -> tuple[Camera, tuple[TrueEffect, ...]]:
    """The case's camera with what is wrong in it, each as severe as wanted."""
    if not wanted.targets:
        return plain, ()
    probe = Probe(plain, place.protocol, place.rates, place.rulers[wanted.base])
    rng = np.random.default_rng([wanted.draw, 2])
    camera, told = plain, []
    for name, target in zip(wanted.own, wanted.targets, strict=False):
        kind = effect_of(name)
        found = dressed_own(plain, own_effect(kind, rng), target, probe)
        added = found.camera.get(kind)
        assert isinstance(added, Effect)
        camera = camera.plus(added)
        told.append(_told(name, (name,), kind.stage.value, "own", found))
    if wanted.outside is not None:
        outsider = outsiders()[wanted.outside]
        found = dressed_outside(plain, outsider, wanted.targets[0], probe)
        camera = found.camera
        told.append(_told(outsider.name, outsider.answers, outsider.stage, outsider.source, found))
    return camera, tuple(told)


def _told(
    name: str, answers: tuple[str, ...], stage: str, source: str, found: Dressed
) -> TrueEffect:
    return TrueEffect(
        name=name,
        answers=answers,
        stage=stage,
        source=source,
        parameters=found.parameters,
        severity=found.severity,
        absorbed=found.absorbed,
    )


def _readme(document: SetDocument) -> str:
    return f"""# {document.name}: {len(document.case)} captures with something withheld

Each folder below `cases/` is a capture: `capture.toml`, frames, the light on the sensor as
`rate-LAMP.exr`, and `nominal.toml`, the camera's data sheet, some 2 % off. In some nothing is
wrong, in others one or two effects are, from a catalogue or from elsewhere. `set.toml` lists the
cases; a case with `without` may not be explained by the effects named there, whatever is wrong.

Answer each case NAME with a gap report, `NAME.json` (format {GAP_FORMAT}), all in one folder,
then write their hashes into it: `sha256sum *.json > SHA256SUMS`. Only then is the seal opened.
Its SHA-256 is the commitment in `set.toml`:

    {document.commitment}

`camtruth blind score` compares it before it looks inside.
"""
