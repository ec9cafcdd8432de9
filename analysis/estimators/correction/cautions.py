"""Where the model of the corrected estimator does not hold, or its frames do not tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from analysis.estimators.correction.blocks import Block, Seen
from analysis.estimators.correction.patterns import Patterns
from analysis.estimators.correction.sites import CLOSE, Mosaic
from analysis.estimators.correction.transfer import Transfer
from analysis.estimators.parts.cautions import NO_DARKS, NO_LIGHT, no_panels, places
from sensor.frames import Capture

DOUBTFUL = 1e-4
"""Chance below which a misfit is worth a warning: one false one in 10^4 captures per test."""

OFFSET = 4.0
"""Standard errors from which an offset that the model does not have is worth a warning."""

ONE_LEVEL = "the lit panels have one level: add shots of other levels, or panels"


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelFits:
    """What was made of a channel: its lattices, and the two fits where there are any."""

    channel: str
    blocks: tuple[Block, ...]
    transfer: Transfer | None = None
    patterns: Patterns | None = None


def dark_reason(blocks: Sequence[Block]) -> str:
    """Why dark frames do not tell."""
    darks = [s for block in blocks for s in block.seen if s.shot.dark]
    if not darks:
        return NO_DARKS
    if not any(s.in_range for s in darks):
        share = float(np.mean([s.cell.at_zero for s in darks]))
        return (
            f"the dark frames are clipped: {100 * share:.1f} % of their samples are 0 DN, so they"
            " show neither black nor its noise; raise the camera's black level"
        )
    single = float(np.mean([s.cell.single for s in darks]))
    return (
        "the noise of the dark frames is too far below one step of the codes to be told:"
        f" {100 * single:.0f} % of the sites give the same code in every frame; raise the camera's"
        " gain or its bits"
    )


def no_light_reason(blocks: Sequence[Block]) -> str:
    """Why lit frames do not tell."""
    lit = any(not s.shot.dark for block in blocks for s in block.used)
    return ONE_LEVEL if lit else NO_LIGHT


def cautions_of(
    capture: Capture, mosaic: Mosaic | None, fits: Sequence[ChannelFits]
) -> tuple[str, ...]:
    """What a careful reader must know of the frames before using the figures."""
    found = no_panels(capture)
    found += _of_the_mosaic(mosaic)
    out = _where(fits, lambda s: s.cell.at_top > 0 and not s.in_range)
    if out:
        found.append(f"saturated, so left out: {places(out)}")
    out = _where(fits, lambda s: not s.in_range and not s.cell.at_top)
    if out:
        found.append(f"half or more of the samples at 0 DN, so left out: {places(out)}")
    out = _where(fits, lambda s: s.in_range and not s.cell.told)
    if out:
        found.append(f"noise too far below one step to be told, so left out: {places(out)}")
    out = _unsteady(fits)
    if out:
        found.append(
            "the level moves from frame to frame, by lamp, clamp or whole rows, which counts as"
            f" noise in time here: {places(out)}"
        )
    for channel in fits:
        found += _of_the_fits(channel)
    return tuple(found)


def _of_the_mosaic(mosaic: Mosaic | None) -> list[str]:
    if mosaic is None:
        return []
    if mosaic.cfa is None:
        return [
            "nobody said which pixels the colours were measured in, and the noise does not show it:"
            " every pixel was used as if measured; state 'cfa'"
        ]
    found = []
    if not mosaic.stated:
        found.append(f"nobody stated the colour mosaic: the noise shows {mosaic.cfa}")
    if mosaic.misfit is not None and mosaic.misfit > CLOSE:
        found.append(
            "noise at the four sites of the mosaic is not that of a bilinear demosaic of"
            f" {mosaic.cfa} (ln variance off by {mosaic.misfit:.2f}): measured samples may have"
            " been changed"
        )
    return found


def _unsteady(fits: Sequence[ChannelFits]) -> list[tuple[str, str, str]]:
    """Cells whose frames' means scatter more than independent sites can."""
    tests = sum(len(block.seen) for f in fits for block in f.blocks)

    def moves(s: Seen) -> bool:
        spare = s.cell.frames - 1
        return bool(stats.chi2.sf(s.cell.frame_chi2 * spare, spare) * tests < DOUBTFUL)

    return _where(fits, lambda s: s.told and moves(s))


def _of_the_fits(fits: ChannelFits) -> list[str]:
    found = []
    transfer, patterns = fits.transfer, fits.patterns
    if transfer is not None and transfer.chance < DOUBTFUL:
        found.append(
            f"{fits.channel}: noise in time is no straight line of level and exposure (chi2"
            f" {transfer.chi2:.0f} of {transfer.freedom}): errors were widened"
        )
    if transfer is not None and _far(transfer.offset_dn):
        found.append(
            f"{fits.channel}: shot noise is not the root of the level (shot_offset): not linear?"
        )
    if patterns is not None and patterns.chance < DOUBTFUL:
        found.append(
            f"{fits.channel}: the patterns of the shots are not one FPN and one PRNU (chi2"
            f" {patterns.chi2:.0f} of {patterns.freedom}): something else is fixed, or moved"
        )
    if patterns is not None and _far(patterns.offset_dn):
        found.append(f"{fits.channel}: PRNU is not proportional to the level (prnu_offset)")
    return found


def _far(figure: tuple[float, float] | None) -> bool:
    return figure is not None and abs(figure[0]) > OFFSET * figure[1]


def _where(fits: Sequence[ChannelFits], test: Callable[[Seen], bool]) -> list[tuple[str, str, str]]:
    order = [s.shot.label for s in fits[0].blocks[0].seen]
    found = [
        (s.shot.label, block.lattice.panel, f.channel)
        for f in fits
        for block in f.blocks
        for s in block.seen
        if test(s)
    ]
    return sorted(found, key=lambda place: order.index(place[0]))
