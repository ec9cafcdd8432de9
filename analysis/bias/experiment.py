"""What the measures of section III found, panel by panel, ready for the technique's variants."""

from __future__ import annotations

from analysis.bias.prediction import Seen
from analysis.parameters import NoiseParameters
from sensor.protocol import Protocol


def seen_of(found: NoiseParameters, protocol: Protocol, size_px: int = 50) -> dict[str, list[Seen]]:
    """The points of a measurement by channel."""
    shots = {shot.label: shot for shot in protocol.shot}
    seen: dict[str, list[Seen]] = {}
    for point in found.points:
        shot = shots[point.shot]
        seen.setdefault(point.channel, []).append(
            Seen(
                shot=point.shot,
                dark=shot.dark,
                exposure_s=shot.exposure_s,
                frames=shot.frames,
                rows=size_px,
                mean_dn=point.mean_dn,
                temporal_dn=point.temporal_dn,
                spatial_dn=point.spatial_dn,
            )
        )
    return seen
