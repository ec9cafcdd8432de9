"""Which cases a set has, and what is wrong in each: drawn from a seed and a secret.

The seed alone would let anybody make the truth again from this code, so 32 random bytes go in with
it. They are kept in the seal.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camtruth.blind.errors import BlindError
from camtruth.blind.foreign.library import outsiders
from camtruth.blind.format import GROUPS
from camtruth.blind.ruler import scaled_figures
from camtruth.blind.worn import fits
from foundation.errors import unknown
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Protocol
from sensor.simulation import light_on

DEFAULT_CASES = {
    "null": 40,
    "own": 48,
    "pair": 20,
    "left-out": 20,
    "decoy": 20,
    "put-back": 20,
    "others": 20,
    "strange": 28,
}

WEAKEST, STRONGEST = 1.0, 16.0
"""Severities that are aimed at, in detection limits: evenly in their logarithm."""

SPREAD = 0.2
"""Relative spread of a base figure from camera to camera."""

NOMINAL_SPREAD = 0.02
"""By how much a data sheet is off."""

BRIGHT, FILLED = 0.99, 0.7
"""This quantile of the brightest shot is set to this part of the largest pixel value."""

WANTS_COLOURS = frozenset(
    {"demosaic_other", "chroma_subsampling", "color_matrix", "jpeg", "sharpening"}
    | {"spatial_denoise", "white_balance"}
)


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """A case before it is made.

    Attributes:
        name: opaque.
        group: one of `GROUPS`.
        base: preset that its camera is like.
        own: effects of the catalogue, by name.
        outside: an effect from elsewhere, by name.
        targets: severity that each is to have.
        without: effects that may not be suspected.
        twin: name of the left-out case whose camera and effect it has.
        draw: seed of the camera's figures and the effects' parameters.
        seed, body_seed: of the capture.
    """

    name: str
    group: str
    base: str
    own: tuple[str, ...] = ()
    outside: str | None = None
    targets: tuple[float, ...] = ()
    without: tuple[str, ...] = ()
    twin: str | None = None
    draw: int
    seed: int
    body_seed: int


def counts(options: Mapping[str, int]) -> dict[str, int]:
    """Cases by group: what was asked for, or the defaults where nothing was.

    Raises:
        BlindError: for an unknown group, or no case at all.
    """
    for group in options:
        if group not in GROUPS:
            raise unknown("kind of case", group, GROUPS, BlindError)
    chosen = dict(options) if options else dict(DEFAULT_CASES)
    if chosen.get("put-back", 0) > chosen.get("left-out", 0):
        raise BlindError(
            f"{chosen['put-back']} put-back cases",
            f"expected at most {chosen.get('left-out', 0)}, as many as there are left-out ones",
            "ask for fewer, or for more of those",
        )
    if not any(chosen.values()):
        raise BlindError("no case at all", "expected at least one", "as in --cases null=1")
    return chosen


def design(
    asked: Mapping[str, int], bases: Mapping[str, Camera], seed: int, secret: bytes
) -> list[Wanted]:
    """The cases, in random order.

    Raises:
        BlindError: when a group asks for code that is not installed.
    """
    digest = hashlib.sha256(secret + seed.to_bytes(8, "little")).digest()
    rng = np.random.default_rng(np.frombuffer(digest, dtype=np.uint32))
    own = _shuffled(rng, [n for n, kind in catalogue().items() if not kind.base])
    strange = _shuffled(rng, [n for n, o in outsiders().items() if o.source == "none"])
    others = _shuffled(rng, [n for n, o in outsiders().items() if o.source != "none"])
    names = [f"{v:010x}" for v in rng.integers(16**10, size=sum(asked.values()))]
    made: list[Wanted] = []

    def case(group: str, own: tuple[str, ...] = (), outside: str | None = None) -> Wanted:
        usable = [
            name
            for name, camera in bases.items()
            if (outside is None or fits(camera, outsiders()[outside]))
            and (camera.get(Demosaic) is not None or not WANTS_COLOURS & set(own))
        ]
        if not usable:
            raise BlindError(
                f"no camera for '{outside or own[0]}'",
                "expected one whose frames have three colours in every pixel",
                "add one, as in --camera i400",
            )
        ends = float(np.log(WEAKEST)), float(np.log(STRONGEST))
        effects = len(own) + (outside is not None)
        draw, frames, body = (int(v) for v in rng.integers(2**31, size=3))
        found = Wanted(
            name=names[len(made)],
            group=group,
            base=str(rng.choice(usable)),
            own=own,
            outside=outside,
            targets=tuple(float(v) for v in np.exp(rng.uniform(ends[0], ends[1], size=effects))),
            draw=draw,
            seed=frames,
            body_seed=body,
        )
        made.append(found)
        return found

    for _ in range(asked.get("null", 0)):
        case("null")
    for k in range(asked.get("own", 0)):
        case("own", (own[k % len(own)],))
    for _ in range(asked.get("pair", 0)):
        one, two = rng.choice(own, size=2, replace=False)
        case("pair", (str(one), str(two)))
    for k in range(asked.get("others", 0)):
        case("others", outside=others[k % len(others)])
    for k in range(asked.get("strange", 0)):
        case("strange", outside=strange[k % len(strange)])
    for k in range(asked.get("decoy", 0)):
        name = own[-1 - k % len(own)]
        found = case("decoy", (name,))
        other = str(rng.choice([n for n in own if n != name]))
        made[made.index(found)] = dataclasses.replace(found, without=(other,))
    for k in range(asked.get("left-out", 0)):
        name = own[(7 + k) % len(own)]
        found = case("left-out", (name,))
        made[made.index(found)] = dataclasses.replace(found, without=(name,))
        if k < asked.get("put-back", 0):
            twin = case("put-back", (name,))
            made[made.index(twin)] = dataclasses.replace(
                found, name=twin.name, group="put-back", seed=twin.seed, twin=found.name
            )
    return [made[k] for k in rng.permutation(len(made))]


def _shuffled(rng: np.random.Generator, names: list[str]) -> list[str]:
    return [names[k] for k in rng.permutation(len(names))]


def exposed(base: Camera, protocol: Protocol, rates: Mapping[str, NDArray[np.float32]]) -> Camera:
    """The camera with its light set as a photographer would: the brightest shot nearly fills it.

    A preset is made for one number of pixels; of larger pixels each catches more.
    """
    brightest = [0.0]
    for shot in protocol.shot:
        if shot.dark:
            continue
        electrons = np.asarray(light_on(base, shot, rates) * shot.exposure_s)
        dn = electrons * np.array(list(base.gain_dn_per_e), dtype=np.float32)
        brightest.append(float(np.quantile(dn, BRIGHT)))
    if max(brightest) == 0:
        return base
    factor = FILLED * base.format.top_dn / max(brightest)
    return dataclasses.replace(base, sensitivity=base.sensitivity.map(lambda s: s * factor))


def body(base: Camera, wanted: Wanted) -> Camera:
    """The case's own camera: gain, black level, noises and patterns drawn anew."""
    rng = np.random.default_rng(wanted.draw)
    drawn = _varied(base, rng, SPREAD)
    black = drawn.black_dn + float(rng.uniform(-0.5, 2.0))
    return dataclasses.replace(
        drawn, name="withheld", black_dn=max(1.0, black), body_seed=wanted.body_seed
    )


def nominal(camera: Camera, wanted: Wanted) -> Camera:
    """The camera's data sheet: its figures, each a little off."""
    rng = np.random.default_rng([wanted.draw, 1])
    off = _varied(camera, rng, NOMINAL_SPREAD)
    return dataclasses.replace(off, body_seed=0, name="nominal")


def _varied(camera: Camera, rng: np.random.Generator, spread: float) -> Camera:
    gain = float(np.exp(rng.normal(0, spread)))
    effects: list[Effect] = []
    for kind in (Prnu, Fpn, ReadNoise):
        effect = camera.get(kind)
        if effect is not None:
            factor = float(np.exp(rng.normal(0, spread)))
            effects.append(scaled_figures(effect, factor, 0.0))
    light = float(np.exp(rng.normal(0, spread / 4))) / gain
    return dataclasses.replace(
        camera.plus(*effects),
        gain_dn_per_e=Colours.of(camera.gain_dn_per_e).map(lambda g: g * gain),
        sensitivity=camera.sensitivity.map(lambda s: s * light),
        black_dn=camera.black_dn * float(np.exp(rng.normal(0, spread))),
    )
