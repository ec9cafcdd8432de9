"""Effects that are easily taken for each other, and the capture in which they differ."""

from __future__ import annotations

from collections.abc import Sequence

SEPARATED_BY: tuple[tuple[frozenset[str], str], ...] = (
    (
        frozenset({"row_noise", "black_level_drift", "flicker_noise", "interference"}),
        "50 or more full-height darks at the shortest exposure: the spectrum of the rows' offsets",
    ),
    (
        frozenset({"random_telegraph_noise", "hot_pixels", "dark_current"}),
        "200 or more darks at two exposures a factor of 4 apart: levels and times of single pixels",
    ),
    (
        frozenset({"sharpening", "spatial_denoise", "demosaic_other", "defocus_error", "jpeg"}),
        "the chart in focus at two levels a factor of 4 apart: edges at two contrasts",
    ),
    (
        frozenset({"crosstalk", "color_matrix", "white_balance", "spectral_response_error",
                   "lamp_spectrum_error", "chroma_subsampling"}),
        "raw Bayer frames of the same shots, under both lamps",
    ),
    (
        frozenset({"vignetting_excess", "lamp_displacement", "specular_glare", "veiling_glare",
                   "lens_distortion", "dust_shadow", "large_scale_prnu"}),
        "the chart turned by 180 degrees, and again at another aperture",
    ),
    (
        frozenset({"lamp_flicker", "lamp_drift", "dropped_frames", "vibration"}),
        "a stack of 200 frames, and one at another exposure time",
    ),
    (
        frozenset({"brighter_fatter", "nonlinearity", "gamma", "blooming", "smear"}),
        "six or more levels up to saturation at one exposure time",
    ),
    (
        frozenset({"image_lag", "temporal_filter", "charge_transfer_inefficiency"}),
        "a step of light: 20 frames in the dark right after 20 lit ones; a filter acts in the dark"
        " as well",
    ),
    (
        frozenset({"ambient_light", "dark_current", "black_level_offset", "dark_shot"}),
        "darks with the lens capped and uncapped, at three exposures",
    ),
    (
        frozenset({"adc_dnl", "bit_truncation", "quantization"}),
        "a defocused uniform field with a ramp of light: every code is visited",
    ),
    (
        frozenset({"column_fpn"}),
        "100 or more full-height darks and as many lit frames at one exposure time: offsets of"
        " columns are the same in both",
    ),
    (
        frozenset({"lateral_chromatic_aberration"}),
        "raw Bayer frames of sharp edges in the centre and in all four corners: red and blue move"
        " along the radius, and the more the farther out",
    ),
    (
        frozenset({"defect_correction"}),
        "200 or more raw darks at two exposures a factor of 4 apart: a hot pixel is gone as soon as"
        " it stands out by more than the threshold",
    ),
)  # fmt: skip
"""Effects that are confused with each other, and the capture in which they differ.

Every effect of the catalogue is in a group. One that is alone in its group is confused with none:
to join others changes what a diagnosis says, see `confused`.
"""


def confused(one: str, other: str) -> bool:
    """Whether two effects are of those that are confused with each other.

    Args:
        one, other: their names.
    """
    return any({one, other} <= group for group, _ in SEPARATED_BY)


def next_capture(names: Sequence[str]) -> str:
    """The capture that separates effects which these frames do not tell apart."""
    best = max(SEPARATED_BY, key=lambda entry: len(entry[0] & set(names)))
    if len(best[0] & set(names)) >= min(2, len(names)):
        return best[1]
    texts = [text for group, text in SEPARATED_BY if group & set(names)]
    return "; and ".join(dict.fromkeys(texts)) or "twice as many frames of the same shots"
