"""Where pictures are steady searches need not begin with what moves them."""

from __future__ import annotations

from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, look
from analysis.gap.ready.steady_pictures import of_a_lamp
from analysis.gap.ready.vibration import trembling
from analysis.gap.suspects.direct_readings import hints_of_frames
from sensor.effect import Effect
from sensor.effects.defect_correction import DefectCorrection
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.vibration import Vibration
from sensor.record import record
from tests.short import PROTOCOL, camera, light
from tests.test_gap_vibration import setting as moved


def setting(*effects: Effect) -> Setting:
    taken = record(camera().plus(*effects).with_body(4), PROTOCOL, {"lamp": light().rate_e_per_s})
    found = look(taken, {"lamp": light()})
    assert found is not None
    return found


def test_a_lamp_that_changes_in_time_may_change_in_any_way() -> None:
    """A drift of a fifth within a shot is a walk; shot noise of a frame's mean is none."""
    drift = LampDrift(change=0.2, time_constant_s=0.5)
    assert of_a_lamp(setting(drift).key_frames) == {}
    steady = of_a_lamp(setting().key_frames)
    assert steady == {"filament": drift.filament, "on_before": drift.on_before}


def test_defects_beyond_all_neighbours_are_looked_for_where_edges_come_and_go() -> None:
    """Whatever moves them; without that noise is that of the light."""
    for effects, hints in (
        ((Vibration(shift_px=0.3, blur_px=0.0),), {}),
        ((), {"beyond_all": 0.0}),
    ):
        found = moved(*effects)
        _, base = by_moments(found)
        told = [Vibration.name] if trembling(found) else []
        assert hints_of_frames(found, base, told)[DefectCorrection.name] == hints
