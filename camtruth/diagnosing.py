"""Real frames against simulated ones: the facade of the diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from analysis.gap.diagnose import Diagnosis
from analysis.gap.diagnose import diagnose as diagnosed
from analysis.gap.report import GapReport
from foundation.errors import unknown
from render.rate import RateImage, read_rate
from sensor.camera import Camera
from sensor.camera_file import load, preset_names
from sensor.capture_folder import inside, read_capture, read_manifest
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.errors import CameraError
from sensor.frames import Capture

Watch = Callable[[str], None]


def diagnose(
    real: Capture | Path | str,
    model: Camera | str | None = None,
    *,
    without: Iterable[str] = (),
    more: Iterable[type[Effect]] = (),
) -> GapReport:
    """Where a simulated camera differs from the real one, why, and how far the gap shrinks.

    Args:
        real: frames, or the folder that holds them.
        model: a camera to start from, by name, file or itself; it is calibrated in any case.
        without: names of effects that are not suspected.
        more: kinds of effect that are suspected besides those of the catalogue.

    Raises:
        InputError: for frames that cannot be read, a scene they do not show, or an unknown effect.
    """
    return diagnosis(real, model, without=without, more=more).report


def diagnosis(
    real: Capture | Path | str,
    model: Camera | str | None = None,
    *,
    without: Iterable[str] = (),
    more: Iterable[type[Effect]] = (),
    watch: Watch = lambda what: None,
) -> Diagnosis:
    """Diagnose real frames, as `diagnose` does: the report, and all that was found on the way.

    Args:
        real, model, without, more: see `diagnose`.
        watch: told what is being done.
    """
    kinds = suspects(without, more)
    stated: Mapping[str, RateImage] = {}
    if not isinstance(real, Capture):
        folder = Path(real)
        real, stated = read_capture(folder), rates_of(folder)
    camera = load(model) if isinstance(model, str) else model
    if camera is not None:
        refuse_other_format(camera, real)
    elif real.camera in preset_names():
        preset = load(real.camera)
        # a preset's name tells its gain, not that its extra effects are there
        camera = preset.without(*(type(e) for e in preset.effects if not e.base))
    return diagnosed(real, camera, stated=stated, suspects=kinds, watch=watch)


def suspects(without: Iterable[str], more: Iterable[type[Effect]]) -> list[type[Effect]]:
    """The kinds of effect that are suspected."""
    known = {name: kind for name, kind in catalogue().items() if not kind.base}
    known |= {kind.name: kind for kind in more}
    for name in without:
        if name not in known:
            raise unknown("effect", name, known, CameraError)
    return [kind for name, kind in known.items() if name not in set(without)]


def rates_of(folder: Path) -> dict[str, RateImage]:
    """The rate images that a capture folder states, by lamp."""
    found = {}
    for shot in read_manifest(folder).shot:
        if shot.rate is not None and len(shot.light) == 1 and shot.light[0] not in found:
            found[shot.light[0]] = read_rate(inside(folder, shot.rate))
    return found


def refuse_other_format(camera: Camera, real: Capture) -> None:
    """A model must make the kind of frames that it is compared with.

    Raises:
        CameraError: when it does not.
    """
    first = real.frames[0]
    ours = (camera.pixels, camera.bits, camera.width, camera.height)
    theirs = (first.pixels, first.bits, first.width, first.height)
    if ours != theirs:
        raise CameraError(
            f"the model makes {_spelt(*ours)}",
            f"expected {_spelt(*theirs)} as the capture has",
            "choose another model, or correct pixels, bits, width and height in it",
        )


def _spelt(pixels: str, bits: int, width: int, height: int) -> str:
    return f"{pixels} of {bits} bits, {width} x {height}"
