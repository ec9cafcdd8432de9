"""How the parameters of an effect are turned: which of them, by what step, inside their ranges."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect, Parameter

WIDE = 4.0
"""Tenths of a strength by which it is moved: twins differ by rounding too, and a small step would
be a direction of noise, along which every amount comes out too small."""


@dataclass(frozen=True, kw_only=True)
class Handle:
    """A parameter of an effect that calibration turns.

    Attributes:
        effect, parameter: names.
        channel: index, where the parameter is one of three by colour.
    """

    effect: str
    parameter: str
    channel: int | None = None


def free_parameters(effect: Effect) -> list[Parameter]:
    """The parameters of an effect that can be fitted: strengths that are on, and shapes."""
    return [
        p
        for p in effect.parameters()
        if not (p.whole or p.stated)
        and isinstance(getattr(effect, p.name), float)
        and not (p.identity is not None and getattr(effect, p.name) == p.identity)
    ]


def handles_of(effect: Effect, p: Parameter, channels: Sequence[str]) -> list[Handle]:
    """How a parameter can be turned: as it is, or colour by colour; not at all if it is off."""
    value = getattr(effect, p.name)
    if p in free_parameters(effect):
        return [Handle(effect=effect.name, parameter=p.name)]
    if not isinstance(value, Colours) or len(channels) == 1:
        return []
    return [
        Handle(effect=effect.name, parameter=p.name, channel=c)
        for c, name in enumerate(channels)
        if value[name] != p.identity
    ]


def moved(effect: Effect, moves: Mapping[Handle, float]) -> Effect:
    """An effect with its parameters moved, each inside its range."""
    values: dict[str, Any] = {}
    for p in effect.parameters():
        own = {h.channel: by for h, by in moves.items() if h.parameter == p.name}
        if not own:
            continue
        value = getattr(effect, p.name)
        if isinstance(value, Colours):
            values[p.name] = Colours(
                **{n: p.clipped(value[n] + own.get(c, 0.0)) for c, n in enumerate(CHANNELS)}
            )
        else:
            values[p.name] = p.clipped(value + own[None])
    return dataclasses.replace(effect, **values)


def step_of(effect: Effect, p: Parameter, channel: int | None = None) -> float:
    """Step of a parameter's difference quotient: a tenth of a shape, four of a strength."""
    value = getattr(effect, p.name)
    value = value[CHANNELS[channel or 0]] if isinstance(value, Colours) else float(value)
    return step_from(value, p, 1.0 if p.identity is None else WIDE)


def step_from(value: float, p: Parameter, times: float = 1.0) -> float:
    """A tenth of a value, or a hundredth of the range, so many times.

    Up where there is room, or else to the side that has more.
    """
    size = abs(value) if p.identity is None or p.inverse else abs(value - p.identity)
    step = times * 0.1 * (size or 0.1 * (p.maximum - p.minimum))
    up, down = min(step, p.maximum - value), min(step, value - p.minimum)
    return up if up == step or up > down else -down


NOTHING = 4e-3
"""Part of what an effect usually does. One that does less and is seen all the same is seen by how
it rounds: a power of 1.0000002 sends halves to another side. The least that the bench's frames tell
of any effect is a hundredth."""


def does_nothing(effect: Effect) -> bool:
    """Whether every strength of an effect is off but for so little that no camera has it.

    Args:
        effect: at fitted parameters; one without strengths always does something.
    """
    strengths = [
        (p, getattr(effect, p.name)) for p in effect.parameters() if p.identity is not None
    ]
    if effect.product and any(value == p.identity for p, value in strengths):
        return True
    return bool(strengths) and all(_is_off(p, value) for p, value in strengths)


def _is_off(strength: Parameter, value: float | Colours) -> bool:
    off = strength.identity or 0.0
    usually = abs(strength.default - off) or 0.1 * (strength.maximum - strength.minimum)
    values = [value[c] for c in CHANNELS] if isinstance(value, Colours) else [value]
    if strength.inverse:
        return all(one >= min(strength.default / NOTHING, off) for one in values)
    return all(abs(one - off) < NOTHING * usually for one in values)
