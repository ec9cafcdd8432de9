"""What to capture: shots as data, in the order they are taken."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from foundation.documents import NAME, STRICT, read_toml
from foundation.errors import unknown
from sensor.errors import ProtocolError

DARK = "none"
"""The name of the light that is no light: cap on, or lamp off in a dark room."""


def several(value: Any) -> Any:
    """One name or number stands for a list of one."""
    if isinstance(value, (str, int, float)):
        return (value,)
    return tuple(value) if isinstance(value, list) else value


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A stack of frames taken without touching anything.

    Attributes:
        label: what to call it; also the stem of its file.
        light: names of the lamps that are on, or ``("none",)``.
        level: level of each lamp relative to the rate image, one per lamp.
        exposure_s: integration time of a frame in s.
        frames: how many frames.
        interval_s: time from the start of a frame to the start of the next in s, if known.
        temperature_c: temperature of the sensor in degrees Celsius, if known.
    """

    label: Annotated[str, NAME]
    light: Annotated[tuple[str, ...], BeforeValidator(several), Field(min_length=1)] = (DARK,)
    level: Annotated[
        tuple[Annotated[float, Field(ge=0)], ...], BeforeValidator(several), Field(min_length=1)
    ] = (1.0,)
    exposure_s: Annotated[float, Field(ge=0, le=1e5)]
    frames: Annotated[int, Field(ge=1, le=10_000_000)]
    interval_s: Annotated[float, Field(gt=0)] | None = None
    temperature_c: Annotated[float, Field(ge=-273.15, le=200)] | None = None

    __pydantic_config__ = STRICT

    def __post_init__(self) -> None:
        if len(self.level) != len(self.light):
            raise ProtocolError(
                f"shot '{self.label}' has {len(self.light)} lights and {len(self.level)} levels",
                "expected one level per light",
                "make the two lists equally long",
            )
        if DARK in self.light and len(self.light) > 1:
            raise ProtocolError(
                f"shot '{self.label}' has light 'none' together with a lamp",
                "expected lamps, or 'none' alone",
                "remove one of them",
            )

    @property
    def dark(self) -> bool:
        """Whether no light reaches the sensor."""
        return self.light == (DARK,) or not any(self.level)


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """A named list of shots.

    `shot` keeps the spelling of the TOML file, where each shot is a ``[[shot]]``.
    """

    name: str
    shot: Annotated[tuple[Shot, ...], Field(min_length=1)]

    __pydantic_config__ = STRICT

    def __post_init__(self) -> None:
        labels = [shot.label for shot in self.shot]
        for label in labels:
            if labels.count(label) > 1:
                raise ProtocolError(
                    f"two shots are called '{label}' in protocol '{self.name}'",
                    "expected every label once",
                    "rename one of them",
                )

    @property
    def lamps(self) -> tuple[str, ...]:
        """The lamps that the shots need, each once, in order of first use."""
        return tuple(
            dict.fromkeys(name for shot in self.shot for name in shot.light if name != DARK)
        )


def preset_names() -> list[str]:
    """The protocols that come with the package."""
    folder = resources.files("sensor") / "protocols"
    return sorted(
        p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml")
    )


def load(name: str) -> Protocol:
    """A protocol by preset name or by the path of a TOML file.

    Raises:
        ProtocolError: for a name that is neither.
        DocumentError: for a file that is not a protocol.
    """
    if name in preset_names():
        return read_toml(
            Path(str(resources.files("sensor") / "protocols" / f"{name}.toml")), Protocol
        )
    if Path(name).suffix == ".toml":
        return read_toml(Path(name), Protocol)
    raise unknown("protocol", name, preset_names(), ProtocolError)
