"""The corrected estimator: the same frames as Irie et al., without the biases of their arithmetic.

Model of a native site i in shot s of exposure t, in DN before rounding and clipping:

    x = b + o_i + I_si (1 + p_i) + noise in time,
    variance of the noise in time:  read^2 + D t + gain I,

o and p the fixed patterns, of variance FPN^2 and PRNU^2. What the printed technique takes off
standard deviation by standard deviation is here a term of a variance, and every term is fitted
where the model has it:

1. Only native sites of the mosaic are read, which a demosaic leaves alone (`correction.sites`).
2. Rounding and clipping are part of the likelihood of the codes (`correction.codes`); where noise
   is well above a step, moments tell the same (`correction.cells`).
3. Shading is a polynomial whose degree is tested; degrees of freedom are counted
   (`correction.shading`).
4. Read noise, dark current and gain are one weighted line through all panels and shots
   (`correction.transfer`).
5. FPN and PRNU are one fit to the covariances of the shots over sites, in which what averaging
   leaves of the noise in time is known (`correction.patterns`).

Standard errors come from the information of these fits. Those of patterns are of as many sites as
there are, however many shots: they say how far this body may be from the make that it comes from.

In the terms of the paper `shot_coefficient` is the root of the gain and `prnu_slope` is PRNU;
`shot_offset` and `prnu_offset`, which this model does not have, are what one more free term finds,
so a figure many errors from 0 says that the model does not hold.
"""

from __future__ import annotations

import numpy as np

from analysis.estimators.correction.blocks import Block, measure_blocks
from analysis.estimators.correction.cautions import (
    ChannelFits,
    cautions_of,
    dark_reason,
    no_light_reason,
)
from analysis.estimators.correction.patterns import Patterns, fit_patterns
from analysis.estimators.correction.points import points_of
from analysis.estimators.correction.sites import mosaic_of
from analysis.estimators.correction.transfer import Transfer, fit_transfer
from analysis.estimators.parts.cautions import ONE_EXPOSURE
from analysis.estimators.parts.observations import require_pairs
from analysis.parameters import UNITS, CannotTell, Estimate, Finding, NoiseParameters, Point
from sensor.frames import Capture

FAINT = 4.0
"""Standard errors that a variance must stand above 0 for its root to be told. A root read off a
fainter one would be far too large whenever it is told at all."""

FEW_LEVELS = "too few levels to tell an offset from a slope: add lit shots of other levels"
NO_PRNU = "needs 'prnu', which these frames cannot tell"

IN_TIME = ("read", "dark_shot", "gain", "shot_coefficient", "shot_offset")
IN_SPACE = ("fpn", "dsnu", "prnu", "prnu_slope", "prnu_offset")
"""What noise in time tells, and what patterns tell."""


def corrected(capture: Capture) -> NoiseParameters:
    """Measure a capture by likelihood, variances and native sites.

    Raises:
        TooFewFrames: where a shot has a single frame.
        CaptureError: where a panel is too small.
    """
    require_pairs(capture)
    mosaic = mosaic_of(capture) if capture.frames[0].demosaiced else None
    channels: dict[str, dict[str, Finding]] = {}
    points: list[Point] = []
    seen: list[ChannelFits] = []
    for channel in capture.channels:
        own = measure_blocks(capture, channel, mosaic.cfa if mosaic else None)
        black = _black(own)
        if black is None:
            channels[channel] = dict.fromkeys(UNITS, CannotTell(reason=dark_reason(own)))
            seen.append(ChannelFits(channel=channel, blocks=own))
        else:
            spread = [block.covariances(k) for block, k in zip(own, black, strict=True)]
            transfer = _transfer(own, black)
            patterns = fit_patterns([c for c in spread if c is not None])
            points += points_of(channel, own, black, spread)
            in_time, in_space = _in_time(transfer, own), _in_space(patterns, own)
            channels[channel] = {key: (in_time | in_space)[key] for key in UNITS}
            seen.append(
                ChannelFits(channel=channel, blocks=own, transfer=transfer, patterns=patterns)
            )
    return NoiseParameters(
        method="corrected",
        channels=channels,
        points=tuple(points),
        warnings=cautions_of(capture, mosaic, seen),
        extra={"mosaic": None if mosaic is None else dict(vars(mosaic))},
    )


def _black(blocks: tuple[Block, ...]) -> tuple[float, ...] | None:
    """Black level of each lattice, that of all together where its own darks do not show it."""
    own = [block.own_black_dn for block in blocks]
    known = [level for level in own if level is not None]
    if not known:
        return None
    mean = float(np.mean(known))
    return tuple(mean if level is None else level for level in own)


def _transfer(blocks: tuple[Block, ...], black: tuple[float, ...]) -> Transfer | None:
    cells = [s.cell for block in blocks for s in block.used]
    if not cells:
        return None
    return fit_transfer(
        variance=np.array([cell.variance_dn2 for cell in cells]),
        se=np.array([cell.variance_se_dn2 for cell in cells]),
        level=np.concatenate([b.levels(k) for b, k in zip(blocks, black, strict=True)]),
        exposure=np.array([s.shot.exposure_s for block in blocks for s in block.used]),
        dark=np.concatenate([block.dark for block in blocks]),
    )


def _in_time(fit: Transfer | None, blocks: tuple[Block, ...]) -> dict[str, Finding]:
    """Read noise, dark-current shot noise, gain, and the paper's curve of shot noise."""
    if fit is None:
        return dict.fromkeys(IN_TIME, CannotTell(reason=dark_reason(blocks)))
    no_gain = no_light_reason(blocks)
    return {
        "read": _root("read", fit.read_dn2, dark_reason(blocks)),
        "dark_shot": _root(
            "dark_shot", fit.dark_dn2, ONE_EXPOSURE if fit.read_dn2 else dark_reason(blocks)
        ),
        "gain": _plain("gain", fit.gain, no_gain),
        "shot_coefficient": _root("shot_coefficient", fit.gain, no_gain),
        "shot_offset": _plain("shot_offset", fit.offset_dn, FEW_LEVELS if fit.gain else no_gain),
    }


def _in_space(fit: Patterns | None, blocks: tuple[Block, ...]) -> dict[str, Finding]:
    """FPN and PRNU, and the paper's line of PRNU."""
    if fit is None:
        return dict.fromkeys(IN_SPACE, CannotTell(reason=dark_reason(blocks)))
    no_prnu = no_light_reason(blocks)
    prnu = _root("prnu", fit.prnu2, no_prnu)
    offset = _plain("prnu_offset", fit.offset_dn, no_prnu)
    return {
        "fpn": _root("fpn", fit.fpn_dn2, dark_reason(blocks)),
        "dsnu": _root("dsnu", fit.fpn_dn2, dark_reason(blocks)),
        "prnu": prnu,
        "prnu_slope": _root("prnu_slope", fit.prnu2, no_prnu),
        "prnu_offset": CannotTell(reason=NO_PRNU) if isinstance(prnu, CannotTell) else offset,
    }


def _plain(key: str, figure: tuple[float, float] | None, otherwise: str) -> Finding:
    if figure is None:
        return CannotTell(reason=otherwise)
    return Estimate(value=figure[0], se=figure[1], unit=UNITS[key])


def _root(key: str, variance: tuple[float, float] | None, otherwise: str) -> Finding:
    """An SD from a variance; none where the variance may be 0."""
    if variance is None:
        return CannotTell(reason=otherwise)
    square, se = variance
    if square <= FAINT * se:
        limit = (max(square, 0.0) + 2 * se) ** 0.5
        return CannotTell(
            reason=f"not seen: these frames only say that it is below {limit:.3g} {UNITS[key]}"
        )
    sd = square**0.5
    return Estimate(value=sd, se=se / (2 * sd), unit=UNITS[key])
