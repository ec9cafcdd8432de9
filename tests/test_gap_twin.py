"""What differs between the twins of a camera besides its body."""

from __future__ import annotations

from analysis.gap.camera.twin import halves_either_way
from sensor.effect import Effect
from sensor.effects.demosaic_other import DemosaicOther
from sensor.effects.quantization import Quantization
from sensor.effects.row_noise import RowNoise
from sensor.effects.spatial_denoise import SpatialDenoise
from tests.effects_bench import bench_camera


def test_halves_of_codes_go_up_in_every_other_body_where_colours_are_weighed() -> None:
    """A mean of four codes and of its neighbours is a half as often as not. Without weights the
    camera's own rule is known from its frames, and stays; so it does of samples that were measured
    behind another demosaicer, where the frames tell that rule."""

    def ways(*effects: Effect, told: bool = False) -> list[float]:
        camera = bench_camera(*effects, height=8, width=8)
        made = [halves_either_way(camera, effects, body, told=told) for body in (10, 11, 12, 13)]
        return [e.halves for one in made for e in one.effects if isinstance(e, Quantization)]

    assert sorted(ways(SpatialDenoise(), RowNoise())) == [-1.0, -1.0, 1.0, 1.0]
    assert ways(RowNoise()) == [0.0] * 4
    assert ways() == [0.0] * 4
    assert sorted(ways(DemosaicOther())) == [-1.0, -1.0, 1.0, 1.0]
    assert ways(DemosaicOther(), RowNoise(), told=True) == [0.0] * 4
    assert sorted(ways(DemosaicOther(), SpatialDenoise(), told=True)) == [-1.0, -1.0, 1.0, 1.0]
