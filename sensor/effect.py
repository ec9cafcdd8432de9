"""What an effect is: a stage of the signal path, parameters with units, and one equation.

An effect that a camera is known to have and one that nobody modelled are the same kind of thing;
the second is merely absent from the model camera.
"""

from __future__ import annotations

import abc
import dataclasses
import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from sensor.colours import CHANNELS, Colours
from sensor.errors import CameraError
from sensor.signal import Quantity, Signal

if TYPE_CHECKING:
    from sensor.stream import Stream


class Stage(Enum):
    """Places along the signal path, in physical order."""

    LIGHTING = "lighting"
    OPTICS = "optics"
    PHOTOSITE = "photosite"
    TRANSFER = "transfer"
    READOUT = "readout"
    ADC = "adc"
    PROCESSING = "processing"
    TRANSPORT = "transport"

    @functools.cached_property
    def place(self) -> int:
        """Position in the signal path."""
        return list(Stage).index(self)

    @property
    def quantity(self) -> Quantity:
        """What the signal is there, unless an effect says otherwise."""
        return _QUANTITY[self]


_QUANTITY = {
    Stage.LIGHTING: Quantity.RATE,
    Stage.OPTICS: Quantity.RATE,
    Stage.PHOTOSITE: Quantity.ELECTRONS,
    Stage.TRANSFER: Quantity.ELECTRONS,
    Stage.READOUT: Quantity.ELECTRONS,
    Stage.ADC: Quantity.DN,
    Stage.PROCESSING: Quantity.DN,
    Stage.TRANSPORT: Quantity.CODE,
}


FAR_AWAY = 100.0
"""Identity over default from which a strength is the inverse of its parameter."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of an effect, as the catalogue shows it.

    Attributes:
        name: with its unit as a suffix where it has one.
        unit: the unit, "1" for a ratio.
        default: the value that a typical camera of the paper's time has.
        minimum, maximum: the plausible range; values outside are refused.
        identity: the value at which the effect does nothing, if this parameter is its strength.
        per_colour: whether it may differ between R, G and B.
        whole: whether only whole numbers have a meaning: a choice, a number of bits.
        starts: values from which a search for it should begin, where the default is not enough.
        stated: whether no search turns it: whoever built the scene states it, or calibration takes
            it up to the last digit.
        doc: one line.
    """

    name: str
    unit: str
    default: float
    minimum: float
    maximum: float
    identity: float | None
    per_colour: bool
    doc: str
    whole: bool = False
    starts: tuple[float, ...] = ()
    stated: bool = False

    @property
    def inverse(self) -> bool:
        """Whether its identity is so far away that a strength is its inverse: of a full well, of a
        threshold.
        """
        identity = self.identity
        return identity is not None and identity > FAR_AWAY * max(abs(self.default), 1e-9)

    def away(self, value: float, factor: float) -> float:
        """A value so many times as far from the identity, inside the range; of a threshold one that
        is so many times as low.
        """
        assert self.identity is not None, "a strength has a value at which the effect vanishes"
        if self.inverse and value > 0:
            return self.clipped(value / factor if factor > 0 else self.identity)
        return self.clipped(self.identity + factor * (value - self.identity))

    def clipped(self, value: float) -> float:
        """The value of the range that is nearest."""
        return min(max(float(value), self.minimum), self.maximum)


def parameter(
    default: float,
    *,
    unit: str,
    minimum: float,
    maximum: float,
    doc: str,
    identity: float | None = None,
    per_colour: bool = False,
    whole: bool = False,
    starts: tuple[float, ...] = (),
    stated: bool = False,
) -> Any:
    """Declare a parameter of an effect; see `Parameter`."""
    metadata = {
        "unit": unit,
        "minimum": minimum,
        "maximum": maximum,
        "identity": identity,
        "per_colour": per_colour,
        "whole": whole,
        "starts": starts,
        "stated": stated,
        "doc": doc,
    }
    return dataclasses.field(default=default, metadata=metadata)


def switch(default: float, *, doc: str, starts: tuple[float, ...] = ()) -> Any:
    """Declare a parameter that is 0 or 1, of which each is another way of the effect.

    Args:
        default: which it is.
        doc: what both mean.
        starts: with which searches begin; both by default.
    """
    return parameter(
        default, unit="1", minimum=0.0, maximum=1.0, whole=True, starts=starts, doc=doc
    )


@dataclass(frozen=True, kw_only=True)
class Effect(abc.ABC):
    """One physical effect. Subclasses are final: one file, one class, one equation.

    Class attributes:
        name: as `camtruth effects` lists it.
        stage: where in the signal path it acts.
        position: order among the effects of its stage, smaller first.
        quantity_override: what the signal must be, where it is not what its stage has; see
            `quantity`.
        base: whether it is a term of the paper's equation (1).
        reference: where the model is from.
        history_frames: how many earlier frames it needs to make one (lag, filters in time).
        repeats: whether a frame may be the one before it again.
        product: whether its strengths are factors, so that without any of them it does nothing.
    """

    name: ClassVar[str]
    stage: ClassVar[Stage]
    position: ClassVar[int]
    reference: ClassVar[str]
    base: ClassVar[bool] = False
    quantity_override: ClassVar[Quantity | None] = None
    history_frames: ClassVar[int] = 0
    repeats: ClassVar[bool] = False
    product: ClassVar[bool] = False

    @abc.abstractmethod
    def apply(self, signal: Signal, stream: Stream) -> Signal:
        """The signal after the effect; never changes its argument."""

    @classmethod
    def quantity(cls) -> Quantity:
        """What the signal must be when it reaches the effect."""
        return cls.quantity_override or cls.stage.quantity

    @property
    def rounds(self) -> bool:
        """Whether it takes numbers that nobody has rounded, and rounds what it makes."""
        return False

    @classmethod
    def place(cls) -> tuple[int, int, int]:
        """Position in the whole signal path; effects of a camera stand in this order."""
        return cls.quantity().place, cls.stage.place, cls.position

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """The parameters, in the order they are declared."""
        return tuple(
            Parameter(name=f.name, default=float(f.default), **f.metadata)  # type: ignore[arg-type]
            for f in dataclasses.fields(cls)
        )

    @classmethod
    def with_parameters(cls, values: Mapping[str, Any]) -> Effect:
        """An effect from plain figures: numbers, or tables of R, G, B.

        Raises:
            CameraError: for an unknown parameter, or a value that is no figure.
        """
        known = {p.name: p for p in cls.parameters()}
        figures: dict[str, Any] = {}
        for name, value in values.items():
            if name not in known:
                raise CameraError(
                    f"effect '{cls.name}' has no parameter '{name}'",
                    f"expected {'one of ' + ', '.join(known) if known else 'none'}",
                    f"see `camtruth effects {cls.name}`",
                )
            figures[name] = _figure(cls.name, known[name], value)
        return cls(**figures)

    def __post_init__(self) -> None:
        for known in self.parameters():
            value = getattr(self, known.name)
            if isinstance(value, np.generic):
                # a number of NumPy makes arrays of what it is added to
                value = value.item()
                object.__setattr__(self, known.name, value)
            if isinstance(value, Colours) and not known.per_colour:
                raise CameraError(
                    f"{self.name}.{known.name} has a figure per colour",
                    "expected one figure",
                    "give one number",
                )
            for figure in Colours.of(value):
                if not (math.isfinite(figure) and known.minimum <= figure <= known.maximum):
                    raise CameraError(
                        f"{self.name}.{known.name} = {figure:g}",
                        f"expected {known.minimum:g} to {known.maximum:g} {known.unit}",
                        f"see `camtruth effects {self.name}`",
                    )
                if known.whole and figure != round(figure):
                    raise CameraError(
                        f"{self.name}.{known.name} = {figure:g}",
                        f"expected a whole number from {known.minimum:g} to {known.maximum:g}",
                        f"see `camtruth effects {self.name}`",
                    )

    def values(self) -> dict[str, float | dict[str, float]]:
        """The parameters as documents spell them."""
        return {
            p.name: v.plain() if isinstance(v := getattr(self, p.name), Colours) else float(v)
            for p in self.parameters()
        }


def _figure(effect: str, known: Parameter, value: Any) -> float | Colours:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, Colours):
        return value
    if isinstance(value, Mapping) and set(value) == set(CHANNELS):
        figures = {channel: _figure(effect, known, value[channel]) for channel in CHANNELS}
        return Colours(**figures)  # type: ignore[arg-type]
    raise CameraError(
        f"{effect}.{known.name} = {value!r}",
        "expected a number" + (", or a table of R, G and B" if known.per_colour else ""),
        f"see `camtruth effects {effect}`",
    )
