"""From a measured noise to the noise before rounding and demosaic, as Irie et al. correct it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from analysis.estimators.parts.observations import Observation
from analysis.estimators.parts.quantization import Kind, curve
from analysis.parameters import Point

N_D: Mapping[Kind, Mapping[str, float]] = {
    "temporal": {"R": 0.73, "G": 0.75, "B": 0.73},
    "spatial": {"R": 0.71, "G": 0.77, "B": 0.71},
}
"""What a bilinear demosaic leaves of the noise: Table V, whose temporal column is equations (5) to
(7). Its spatial column holds against noise that went through the same column fit, which is the
noise that the curve of N_Q is drawn against, so the two agree."""


@dataclass(frozen=True, kw_only=True)
class Corrected:
    """A noise in DN as it was before the demosaic.

    Attributes:
        quantization_dn: N_Q, what rounding and the measurement added.
        noise_dn: (measured - N_Q) / N_D, as the text says.
        se_dn: standard error of `noise_dn`.
        printed_dn: measured - N_Q / N_D, as equations (10) and (12) print it.
    """

    quantization_dn: float
    noise_dn: float
    se_dn: float
    printed_dn: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """An observation with both its noises corrected."""

    seen: Observation
    temporal: Corrected
    spatial: Corrected


def read_off(seen: Observation, *, demosaiced: bool) -> Reading:
    """Take N_Q and N_D off an observation; native lattices have no N_D."""
    noise = seen.noise

    def corrected(kind: Kind, measured: float, se: float) -> Corrected:
        n_d = N_D[kind][seen.channel] if demosaiced else 1.0
        at = curve(kind, gradient=not seen.shot.dark, rows=noise.rows, frames=noise.frames)
        before, slope = at.noise_before(measured)
        n_q = measured - before
        return Corrected(
            quantization_dn=n_q,
            noise_dn=before / n_d,
            # At the curve's floor the figure is held at 0; its error is then that of the measure.
            se_dn=se * (slope or 1.0) / n_d,
            printed_dn=measured - n_q / n_d,
        )

    return Reading(
        seen=seen,
        temporal=corrected("temporal", noise.temporal_dn, noise.temporal_se_dn),
        spatial=corrected("spatial", noise.spatial_dn, noise.spatial_se_dn),
    )


def point(reading: Reading, known: Mapping[str, float]) -> Point:
    """A point of Figs. 4 to 6; `known` holds what the method made of it besides."""
    noise = reading.seen.noise
    return Point(
        shot=reading.seen.shot.label,
        panel=reading.seen.panel,
        channel=reading.seen.channel,
        mean_dn=noise.mean_dn,
        temporal_dn=noise.temporal_dn,
        spatial_dn=noise.spatial_dn,
        rows_dn=noise.rows_dn,
        columns_dn=noise.columns_dn,
        more={
            "exposure_s": reading.seen.shot.exposure_s,
            "at_zero": noise.at_zero,
            "at_top": noise.at_top,
            "temporal_se_dn": noise.temporal_se_dn,
            "spatial_se_dn": noise.spatial_se_dn,
            "rows_se_dn": noise.rows_se_dn,
            "columns_se_dn": noise.columns_se_dn,
            "temporal_quantization_dn": reading.temporal.quantization_dn,
            "spatial_quantization_dn": reading.spatial.quantization_dn,
            "temporal_corrected_dn": reading.temporal.noise_dn,
            "spatial_corrected_dn": reading.spatial.noise_dn,
            "temporal_printed_dn": reading.temporal.printed_dn,
            "spatial_printed_dn": reading.spatial.printed_dn,
        }
        | dict(known),
    )
