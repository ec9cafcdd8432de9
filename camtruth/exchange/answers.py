"""What is known of the shots to import, from headers and from the user; nothing is guessed.

What neither says is asked for, all at once: the error lists every missing option.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.reader import Header
from camtruth.exchange.reels import Reel
from foundation.errors import unknown
from sensor.capture_folder import ShotDocument
from sensor.protocol import DARK

ALL = "*"
"""Stands for every shot that has no answer of its own."""

NO_MOSAIC = "none"

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Light:
    """Lamps of a shot and their levels."""

    lamps: tuple[str, ...]
    levels: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Answers:
    """What the user says.

    Attributes:
        exposure_s, light: by label of the shot, or `ALL`.
        camera: what to call it.
        bits: significant bits of a sample.
        cfa: colours of the mosaic, or `NO_MOSAIC`.
        shift: bits to shift samples to the right by.
        shots: the shots of a manifest, by label.
    """

    exposure_s: Mapping[str, float] = field(default_factory=dict)
    light: Mapping[str, Light] = field(default_factory=dict)
    camera: str | None = None
    bits: int | None = None
    cfa: str | None = None
    shift: int | None = None
    shots: Mapping[str, ShotDocument] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Settled:
    """How a shot was taken, and who said so."""

    reel: Reel
    exposure_s: float
    light: Light
    interval_s: float | None
    temperature_c: float | None
    sources: Mapping[str, str]


def parse_pairs(option: str, words: Sequence[str]) -> dict[str, str]:
    """``LABEL=VALUE`` each.

    Raises:
        ExchangeError: for a word of another form.
    """
    pairs = {}
    for word in words:
        label, equals, value = word.partition("=")
        if not (label and equals and value):
            raise ExchangeError(
                f"{option} {word}",
                "expected LABEL=VALUE, or *=VALUE for all others",
                f"see the labels by 'camtruth import' without {option}",
            )
        pairs[label] = value
    return pairs


def parse_exposures(words: Sequence[str]) -> dict[str, float]:
    """``LABEL=SECONDS`` each."""
    return {
        label: _number("--exposure", label, text, 1e5)
        for label, text in parse_pairs("--exposure", words).items()
    }


def parse_lights(words: Sequence[str]) -> dict[str, Light]:
    """``LABEL=LAMP``, ``LABEL=LAMP@LEVEL`` or several lamps with commas between them."""
    lights = {}
    for label, text in parse_pairs("--light", words).items():
        lamps, levels = [], []
        for part in text.split(","):
            lamp, _, level = part.partition("@")
            lamps.append(lamp)
            levels.append(_number("--light", label, level, 1e9) if level else 1.0)
        lights[label] = Light(lamps=tuple(lamps), levels=tuple(levels))
    return lights


def _number(option: str, label: str, text: str, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not 0 <= number <= most:
        raise ExchangeError(
            f"{option} {label}={text}", f"expected a number from 0 to {most:g}", "correct it"
        )
    return number


def settle(reels: Sequence[Reel], answers: Answers) -> tuple[list[Settled], list[str]]:
    """Every shot with its exposure and light, and notes where two sources differ.

    Raises:
        ExchangeError: for a label that no shot has, or when something is not known.
    """
    labels = [reel.label for reel in reels]
    for given in (*answers.exposure_s, *answers.light):
        if given != ALL and given not in labels:
            raise unknown("shot", given, labels, ExchangeError)
    missing: list[str] = []
    notes: list[str] = []
    settled = []
    for reel in reels:
        stated = answers.shots.get(reel.label)
        exposure, by = _exposure(reel, stated, answers, notes)
        light, light_by = _light(reel, stated, answers)
        if exposure is None:
            missing.append(f"--exposure {reel.label}=SECONDS")
        if light is None:
            missing.append(f"--light {reel.label}=LAMP or {DARK}")
        if exposure is not None and light is not None:
            settled.append(
                Settled(
                    reel=reel,
                    exposure_s=exposure,
                    light=light,
                    interval_s=stated.interval_s if stated else None,
                    temperature_c=_first(
                        stated.temperature_c if stated else None, reel.told.temperature_c
                    ),
                    sources={"exposure_s": by, "light": light_by},
                )
            )
    if missing:
        raise ExchangeError(
            f"neither headers nor options say everything about shots {', '.join(labels)}",
            "expected an exposure and a light for each",
            f"pass {' '.join(missing)}",
        )
    return settled, notes


def _exposure(
    reel: Reel, stated: ShotDocument | None, answers: Answers, notes: list[str]
) -> tuple[float | None, str]:
    told = reel.told.exposure_s
    said = answers.exposure_s.get(reel.label)
    if said is not None and told is not None and abs(said - told) > 1e-3 * max(said, told):
        notes.append(
            f"shot '{reel.label}': its {reel.told.where} says {told:g} s, --exposure {said:g} s;"
            " the option was taken"
        )
    if said is not None:
        return said, "option"
    if stated is not None:
        return stated.exposure_s, "manifest"
    if told is not None:
        return told, reel.told.where
    return answers.exposure_s.get(ALL), "option"


def _light(reel: Reel, stated: ShotDocument | None, answers: Answers) -> tuple[Light | None, str]:
    if reel.label in answers.light:
        return answers.light[reel.label], "option"
    if stated is not None:
        return Light(lamps=stated.light, levels=stated.level), "manifest"
    return answers.light.get(ALL), "option"


def _first(*values: T | None) -> T | None:
    return next((value for value in values if value is not None), None)


def camera_of(reels: Sequence[Reel], answers: Answers) -> str:
    """What to call the camera: what the user says, or the one name in all headers.

    Raises:
        ExchangeError: when nobody says, or headers differ.
    """
    if answers.camera is not None:
        return answers.camera
    names = {reel.told.camera for reel in reels} - {None}
    if len(names) == 1:
        return str(names.pop())
    raise ExchangeError(
        f"headers name the cameras {', '.join(sorted(map(str, names)))}"
        if names
        else "no header names the camera",
        "expected one name",
        "pass --camera TEXT",
    )


def mosaic_of(told: Sequence[Header], colour: bool, answers: Answers) -> str | None:
    """The colours of the mosaic; None for a camera without, or unknown for RGB frames.

    Raises:
        ExchangeError: for grey frames of which nobody says whether they are a mosaic.
    """
    if answers.cfa is not None:
        return None if answers.cfa == NO_MOSAIC else answers.cfa
    known = {each.cfa for each in told} - {None}
    if len(known) == 1:
        return known.pop()
    if colour and not known:
        return None
    raise ExchangeError(
        f"frames of one channel, mosaics {', '.join(sorted(map(str, known))) or 'unknown'}",
        "expected to be told whether a colour filter lies over the pixels",
        f"pass --cfa RGGB, BGGR, GRBG or GBRG, or --cfa {NO_MOSAIC} for a grey camera",
    )


def bits_of(told: Sequence[Header], sample_bits: int, answers: Answers) -> int:
    """Significant bits of a sample.

    Raises:
        ExchangeError: for 16-bit samples of which nobody says how many bits are used.
    """
    if answers.bits is not None:
        return answers.bits
    known = {each.bits for each in told} - {None}
    if len(known) == 1:
        return int(str(known.pop()))
    if sample_bits == 8:
        return 8
    raise ExchangeError(
        "samples of 16 bits, and no header says how many of them are used",
        "expected 9 to 16",
        "pass --bits N",
    )
