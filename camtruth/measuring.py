"""Frames alone to noise parameters, and how often those are right."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.bias import domain
from analysis.methods import method as method_named
from analysis.methods import undefined
from analysis.parameters import CannotTell, NoiseParameters
from analysis.round_trip import Row, round_trip
from camtruth.simulating import grey_panels, rates_of
from foundation.jobs import run
from foundation.panel import Panel
from render.rate import RateImage
from sensor.camera import Camera
from sensor.capture_folder import read_capture
from sensor.frames import Capture
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import Protocol
from sensor.record import record
from sensor.truth import population

DEFAULT_METHOD = "irie"


def measure(capture: Capture | Path | str, method: str = DEFAULT_METHOD) -> NoiseParameters:
    """What an estimator reads out of a capture, or a capture folder.

    The paper's technique warns where its closed form says that it does not hold. What one of our
    methods does not define of the paper's parameters is there too, with the reason.

    Args:
        capture: frames, or the folder that holds them.
        method: name of an estimator, or ``FILE.py:function``.

    Raises:
        InputError: for an unknown method or frames that it cannot use.
    """
    estimate = method_named(method)
    if not isinstance(capture, Capture):
        capture = read_capture(Path(capture))
    found = estimate(capture)
    absent = {key: CannotTell(reason=reason) for key, reason in undefined(method).items()}
    found = dataclasses.replace(
        found, channels={channel: {**absent, **told} for channel, told in found.channels.items()}
    )
    if method != DEFAULT_METHOD:
        return found
    return dataclasses.replace(found, warnings=found.warnings + domain.warning(found, capture))


def roundtrip(
    camera: Camera,
    protocol: Protocol,
    images: Mapping[str, RateImage],
    *,
    seeds: Sequence[int],
    methods: Sequence[str] = (DEFAULT_METHOD,),
    panels: Sequence[Panel] | None = None,
    scheduler: str | None = None,
    threads: int | None = None,
    progress: Callable[[int], None] = lambda seeds: None,
) -> tuple[Row, ...]:
    """Truth against estimate over camera bodies: bias, its standard error, and coverage.

    Every seed is another body with its own fixed patterns and its own noise. Only the panels are
    simulated, cut out with a margin: estimators look at nothing else.

    Args:
        camera: the make; its own body seed is not used.
        protocol: the shots.
        images: a rate image for every lamp of the protocol.
        seeds: seeds of the bodies and of their noise.
        methods: names of estimators.
        panels: areas to analyse; the middle of the grey panels by default.
        scheduler: address of a Dask scheduler; this process by default.
        threads: bodies at once in this process; one per core by default.
        progress: told the number of seeds just finished.
    """
    for name in methods:
        method_named(name)
    areas = grey_panels(images) if panels is None else tuple(panels)
    small, rates, moved = panels_only(camera, rates_of(images), areas)
    truth = population(camera, max(shot.exposure_s for shot in protocol.shot))

    trips = Trips(
        camera=small, protocol=protocol, rates=rates, methods=tuple(methods), panels=moved
    )
    found = run(
        _trip,
        {str(seed): seed for seed in seeds},
        shared=trips,
        scheduler=scheduler,
        threads=threads,
        progress=progress,
    )
    return round_trip((truth, each) for answers in found.values() for each in answers)


@dataclass(frozen=True, kw_only=True, eq=False)
class Trips:
    """What all round trips of a table share."""

    camera: Camera
    protocol: Protocol
    rates: Mapping[str, NDArray[np.float32]]
    methods: tuple[str, ...]
    panels: tuple[Panel, ...]


def _trip(shared: Trips, seed: int) -> tuple[NoiseParameters, ...]:
    """What every method makes of one body's frames."""
    body = shared.camera.with_body(seed)
    taken = record(body, shared.protocol, shared.rates, seed=seed, panels=shared.panels)
    return tuple(method_named(name)(taken) for name in shared.methods)
