"""What is told of each suspect before any search: where a reading meets the effect it is of."""

from __future__ import annotations

import dataclasses

from analysis.gap.camera.base import Base
from analysis.gap.measure.case import Case
from analysis.gap.ready.filtered import filtered
from analysis.gap.ready.full_well import brimful, full_well_e
from analysis.gap.ready.hints import Hints, Told, dwell_s, mains_hz
from analysis.gap.ready.hot import hot
from analysis.gap.ready.mixed import mixed
from analysis.gap.ready.room import lit_room
from analysis.gap.ready.setting import Setting
from analysis.gap.ready.soft import soft
from analysis.gap.ready.traps import trapped
from analysis.gap.ready.undone import unbent, unmixed
from analysis.gap.ready.wandering import wandering
from analysis.gap.ready.wave import wave
from analysis.gap.suspects.lobe import lobe_of
from sensor.colours import Colours
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.blooming import Blooming
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.defocus_error import DefocusError
from sensor.effects.gamma import Gamma
from sensor.effects.hot_pixels import HotPixels
from sensor.effects.interference import Interference
from sensor.effects.jpeg import Jpeg
from sensor.effects.lamp_flicker import LampFlicker
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.effects.specular_glare import SpecularGlare


def hints_of_frames(setting: Setting, base: Base) -> dict[str, Hints]:
    """Where searches should begin whatever the model, by effect."""
    stacks = setting.key_frames
    lattices = setting.scenery.view.lattices
    dwell = dwell_s(stacks, lattices)
    found: dict[str, dict[str, float | Colours | None]] = {
        Interference.name: dict(wave(stacks, lattices)),
        LampFlicker.name: {"mains_hz": mains_hz(stacks)},
        RandomTelegraphNoise.name: {"dwell_up_s": dwell, "dwell_down_s": dwell},
        Blooming.name: {"full_well_e": full_well_e(stacks, lattices, base)},
    }
    return {
        effect: {name: value for name, value in hints.items() if value is not None}
        for effect, hints in found.items()
    }


def told_by(setting: Setting, base: Base) -> dict[str, Told]:
    """Suspects of which the frames or the calibrated base tell parameters, and where the camera
    begins with each.
    """
    told = dict(setting.told)
    if disc := soft(base):
        told[DefocusError.name] = disc
    if curve := told.get(Gamma.name):
        told[Gamma.name] = dataclasses.replace(curve, base=unbent(setting, curve))
    if mix := mixed(setting.key_frames, setting.scenery.view.lattices):
        told[ColorMatrix.name] = _with_bases(setting, mix)
    if room := lit_room(setting):
        told[AmbientLight.name] = room
    if spots := hot(setting):
        told[HotPixels.name] = spots
    if chain := trapped(setting):
        # somebody else's traps may jump by other laws
        fitted = Told(hints=chain.hints, exact=False)
        told[RandomTelegraphNoise.name] = dataclasses.replace(chain, instead=fitted)
    if full := brimful(setting):
        told[Blooming.name] = full
    if drift := wandering(setting):
        told[BlackLevelDrift.name] = drift
    # a codec's losses make neighbours agree as well
    if Jpeg.name not in told and (smooth := filtered(setting)):
        told[SpatialDenoise.name] = smooth
    return told


def _with_bases(setting: Setting, mix: Told) -> Told:
    """A matrix as it is told, and as it may be told otherwise, with the camera in front of each."""
    instead = None if mix.instead is None else _with_bases(setting, mix.instead)
    return dataclasses.replace(mix, base=unmixed(setting, mix), instead=instead)


def hints_of(case: Case) -> dict[str, Hints]:
    """Where the search for a place should begin: by what a model leaves of the picture."""
    lobe, body = lobe_of(case), case.known.scenery.body
    if lobe is None:
        return {}
    place = {"across": lobe.x_px / body.width, "below": lobe.y_px / body.height}
    return {SpecularGlare.name: {**place, "sigma_px": lobe.sigma_px}}
