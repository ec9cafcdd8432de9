"""What is told of each suspect before any search: where a reading meets the effect it is of."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping

from analysis.gap.camera.base import Base
from analysis.gap.measure.case import Case
from analysis.gap.ready.ambient_light import lit_room
from analysis.gap.ready.bit_truncation import behind_steps
from analysis.gap.ready.black_level_drift import wandering
from analysis.gap.ready.blooming import brimful
from analysis.gap.ready.color_matrix import mixed
from analysis.gap.ready.defocus_error import soft
from analysis.gap.ready.full_well import full_well_e
from analysis.gap.ready.gamma import bent
from analysis.gap.ready.hints import DirectReading, Hints, dwell_s, mains_hz
from analysis.gap.ready.hot_pixels import hot
from analysis.gap.ready.interference import wave
from analysis.gap.ready.jpeg import behind_blocks
from analysis.gap.ready.random_telegraph_noise import trapped
from analysis.gap.ready.setting import Setting
from analysis.gap.ready.spatial_denoise import filtered
from analysis.gap.ready.steady_pictures import of_a_lamp, of_defects
from analysis.gap.ready.undone import unbent, unmixed, without_leaks
from analysis.gap.ready.vibration import trembling
from analysis.gap.suspects.lobe import lobe_of
from foundation.cores import in_order
from sensor.colours import Colours
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.blooming import Blooming
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.defect_correction import DefectCorrection
from sensor.effects.defocus_error import DefocusError
from sensor.effects.gamma import Gamma
from sensor.effects.hot_pixels import HotPixels
from sensor.effects.interference import Interference
from sensor.effects.jpeg import Jpeg
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.lamp_flicker import LampFlicker
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.effects.specular_glare import SpecularGlare
from sensor.effects.vibration import Vibration

PerhapsHints = Mapping[str, float | Colours | None]


def hints_of_frames(setting: Setting, base: Base, told: Collection[str]) -> dict[str, Hints]:
    """Where searches should begin whatever the model, by effect.

    Args:
        setting: the capture.
        base: the calibrated camera.
        told: names of suspects of which the frames tell parameters.
    """
    stacks = setting.key_frames
    lattices = setting.scenery.view.lattices

    def dwell() -> PerhapsHints:
        one = dwell_s(stacks, lattices)
        return {"dwell_up_s": one, "dwell_down_s": one}

    readings: dict[str, Callable[[], PerhapsHints]] = {
        Interference.name: lambda: wave(stacks, lattices),
        LampFlicker.name: lambda: {"mains_hz": mains_hz(stacks)},
        RandomTelegraphNoise.name: dwell,
        Blooming.name: lambda: {"full_well_e": full_well_e(stacks, lattices, base)},
        LampDrift.name: lambda: of_a_lamp(stacks),
        DefectCorrection.name: lambda: of_defects(Vibration.name in told),
    }
    found = in_order(lambda reading: reading(), readings.values())
    return {
        effect: {name: value for name, value in hints.items() if value is not None}
        for effect, hints in zip(readings, found, strict=True)
    }


def told_by(setting: Setting, base: Base) -> dict[str, DirectReading]:
    """Suspects of which the frames or the calibrated base tell parameters, and where the camera
    begins with each.
    """
    told = dict(setting.told)
    if disc := soft(base):
        told[DefocusError.name] = disc
    if curve := told.get(Gamma.name) or bent(setting):
        told[Gamma.name] = _straightened(setting, curve)
    if steps := told.get(BitTruncation.name):
        told[BitTruncation.name] = dataclasses.replace(
            steps, base=behind_steps(setting, steps, base)
        )
    if codec := told.get(Jpeg.name):
        emptied = dataclasses.replace(codec, base=behind_blocks(setting, base))
        told[Jpeg.name] = dataclasses.replace(codec, instead=emptied if emptied.base else None)
    found = in_order(lambda reading: reading(setting), READINGS.values())
    return told | {name: one for name, one in zip(READINGS, found, strict=True) if one}


def _mixed(setting: Setting) -> DirectReading | None:
    mix = mixed(setting.key_frames, setting.scenery.view.lattices)
    return _with_bases(setting, mix) if mix else None


def _straightened(setting: Setting, curve: DirectReading) -> DirectReading:
    """A curve as it is told, and as it may be told otherwise, with the camera in front of each."""
    instead = None if curve.instead is None else _straightened(setting, curve.instead)
    return dataclasses.replace(unbent(setting, curve), instead=instead)


def _with_bases(setting: Setting, mix: DirectReading) -> DirectReading:
    """A matrix as it is told, and as it may be told otherwise, with the camera in front of each."""
    instead = None if mix.instead is None else _with_bases(setting, mix.instead)
    return dataclasses.replace(mix, base=unmixed(setting, mix), instead=instead)


def _leaking(setting: Setting) -> DirectReading | None:
    leaks = hot(setting)
    return dataclasses.replace(leaks, base=without_leaks(setting)) if leaks else None


def _jumping(setting: Setting) -> DirectReading | None:
    chain = trapped(setting)
    if chain is None:
        return None
    # somebody else's traps may jump by other laws
    return _at_last(chain, DirectReading(hints=chain.hints, exact=False))


def _at_last(told: DirectReading, last: DirectReading) -> DirectReading:
    """What is told, and as it may be told otherwise, with one more at the end."""
    instead = last if told.instead is None else _at_last(told.instead, last)
    return dataclasses.replace(told, instead=instead)


def _smoothed(setting: Setting) -> DirectReading | None:
    # a codec's losses make neighbours agree as well
    return None if Jpeg.name in setting.told else filtered(setting)


READINGS: Mapping[str, Callable[[Setting], DirectReading | None]] = {
    ColorMatrix.name: _mixed,
    RandomTelegraphNoise.name: _jumping,
    AmbientLight.name: lit_room,
    HotPixels.name: _leaking,
    Blooming.name: brimful,
    BlackLevelDrift.name: wandering,
    Vibration.name: trembling,
    SpatialDenoise.name: _smoothed,
}
"""What frames tell of suspects by themselves, by name of the effect."""


def hints_of(case: Case) -> dict[str, Hints]:
    """Where the search for a place should begin: by what a model leaves of the picture."""
    lobe, body = lobe_of(case), case.known.scenery.body
    if lobe is None:
        return {}
    place = {"across": lobe.x_px / body.width, "below": lobe.y_px / body.height}
    shape = {"sigma_px": lobe.sigma_px, "longer": lobe.longer, "slant_deg": lobe.slant_deg}
    return {SpecularGlare.name: place | shape}
