"""The page of `camtruth explore`: every effect, at every strength, in pictures and curves."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exploring import Pair, State
from camtruth.report.pictures import data_url, magnified_change
from camtruth.report.plot import Axis, Marks, axis_over, plot
from camtruth.report.templates import spelt, template
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.truth import versions

Array = NDArray[np.float64]

LEVELS = 14
"""Levels of the mean at which the noise is drawn."""

FEWEST = 40
"""Pixels of a level that is drawn."""


def page(camera: Camera, states: Iterable[State], command: str) -> str:
    """The page as HTML.

    Args:
        camera: without the effects.
        states: with them.
        command: the command line that makes it again.
    """
    found = list(states)
    effects = [_entry(list(same)) for _, same in groupby(found, key=lambda s: s.effect.name)]
    stages = [
        {"name": stage, "effects": [e["name"] for e in same]}
        for stage, same in groupby(effects, key=lambda entry: entry["stage"])
    ]
    first = found[0]
    count, height, width = first.lit.without.shape[:3]
    without = {"lit": _picture(first.lit.without[0]), "dark": _picture(first.dark.without[0])}
    return template("explore.html.j2").render(
        command=command,
        camera=camera.name,
        stages=stages,
        effects={e["name"]: e for e in effects},
        without=without,
        frames=count,
        height=height,
        width=width,
        versions=versions(),
    )


def _entry(states: Sequence[State]) -> dict[str, Any]:
    """What the page says of an effect."""
    effect = states[0].effect
    return {
        "name": effect.name,
        "stage": effect.stage.value,
        "text": inspect.cleandoc(type(effect).__doc__ or ""),
        "source": effect.reference,
        "states": [_state(one) for one in states],
    }


def _state(state: State) -> dict[str, Any]:
    effect = state.effect
    figures = {p.name: (spelt(Colours.of(getattr(effect, p.name)).plain()), p)
               for p in effect.parameters()}  # fmt: skip
    return {
        "parameters": [
            {"name": name, "value": value, "unit": "" if p.unit == "1" else p.unit, "doc": p.doc}
            for name, (value, p) in figures.items()
        ],
        "words": " ".join(
            f"--with {effect.name}.{name}={value}"
            for name, (value, _) in figures.items()
            if "/" not in value
        ),
        "lit": _shown(state.lit),
        "dark": _shown(state.dark),
    }


def _shown(pair: Pair) -> dict[str, Any]:
    """The frame in which most changes, the change itself, and three curves."""
    before, after = (_coloured(f).astype(np.float64) for f in (pair.without, pair.with_it))
    change = after - before
    frame = int(np.abs(change).mean(axis=(1, 2, 3)).argmax())
    picture, times = magnified_change(change[frame])
    return {
        "with": _picture(pair.with_it[frame]),
        "change": data_url(picture),
        "times": times,
        "same": not bool(change.any()),
        "plots": [_transfer(before, after), _columns(change), _spectrum(before, after)],
    }


def _picture(frame: NDArray[Any]) -> str:
    top = 255 if frame.dtype == np.uint8 else max(int(frame.max()), 1)
    return data_url(np.asarray(_coloured(frame[None])[0] * (255.0 / top), np.uint8))


def _coloured(frames: NDArray[Any]) -> NDArray[Any]:
    return frames if frames.ndim == 4 else np.repeat(frames[..., None], 3, axis=3)


def _both(before: tuple[Array, Array], after: tuple[Array, Array]) -> list[Marks]:
    return [
        Marks(x=list(map(float, x)), y=list(map(float, y)), style=style, kind="line")
        for (x, y), style in ((before, "k"), (after, "b"))
    ]


def _drawn(title: str, x_label: str, y_label: str, marks: list[Marks], *, zero: bool) -> str:
    across = [v for mark in marks for v in mark.x]
    up = [v for mark in marks for v in mark.y]
    x = Axis(low=min(across), high=max(max(across), min(across) + 1e-6), label=x_label)
    return plot(title, x, axis_over(up, y_label, zero=zero), marks)


def _transfer(before: Array, after: Array) -> str:
    """Noise in time over the mean, of green."""

    def curve(frames: Array) -> tuple[Array, Array]:
        green = frames[..., 1]
        mean, variance = green.mean(axis=0).ravel(), green.var(axis=0, ddof=1).ravel()
        edges = np.linspace(mean.min(), mean.max() + 1e-9, LEVELS + 1)
        level = np.digitize(mean, edges) - 1
        used = [k for k in range(LEVELS) if (level == k).sum() >= FEWEST]
        levels = np.array([mean[level == k].mean() for k in used] or [mean.mean()])
        noise = np.array([variance[level == k].mean() for k in used] or [variance.mean()])
        return levels, noise

    marks = _both(curve(before), curve(after))
    return _drawn("Photon transfer, green", "mean / DN", "variance in time / DN²", marks, zero=True)


def _columns(change: Array) -> str:
    """By how much each column changes, over its rows and all frames."""
    along = change[..., 1].mean(axis=(0, 1))
    line = Marks(x=list(map(float, range(len(along)))), y=list(map(float, along)), style="b",
                 kind="line")  # fmt: skip
    return _drawn("Change of the columns, green", "column", "DN", [line], zero=True)


def _spectrum(before: Array, after: Array) -> str:
    """Power of the noise in time, along the rows."""

    def curve(frames: Array) -> tuple[Array, Array]:
        noise = frames[..., 1] - frames[..., 1].mean(axis=0)
        power = np.square(np.abs(np.fft.rfft(noise, axis=-1))).mean(axis=(0, 1)) / noise.shape[-1]
        frequency = np.fft.rfftfreq(noise.shape[-1])
        return np.asarray(frequency, np.float64), np.log10(power + 1e-4)

    marks = _both(curve(before), curve(after))
    return _drawn(
        "Spectrum of the noise along rows", "cycles / pixel", "log₁₀ of DN²", marks, zero=False
    )
