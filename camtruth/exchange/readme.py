"""The page that lies in an export: what it holds and how to read it without camtruth."""

from __future__ import annotations

from collections.abc import Sequence

from camtruth.exchange.format import Format
from camtruth.exchange.source import Source
from camtruth.exchange.truth_maps import Map

PAGE = """# Frames of camera '{camera}'

{frames} frames in {shots} shots, {width} x {height} pixels, {pixels}, {bits} significant bits, \
right-justified{cfa}. Format: {says}.

Read a file, here in Python:

    {reading}

`frames.csv` has a row for each frame: the file, the place in it, and how it was taken (`level` is
relative to the lamp's rate image; `light` is `none` in the dark).
{truth}
Check the folder with `sha256sum --check SHA256SUMS`, or `camtruth verify`.

Licence: {licence}, see LICENSE.txt. `croissant.json` is the dataset card.
"""

TRUTH = """
## What is known

The camera is simulated. `truth.json` states every effect with its parameters and units, the seeds,
the versions of the programs, and under `noise` what an ideal estimator would find in each channel:
the value of the population that camera bodies come from, and that of this very body.

    mean electrons = rate x sensitivity x level x exposure
    code           = round(gain x (electrons x response + offset + noise) + black level), clipped

gain = {gain} DN/e-, black level = {black} DN. `rate-LAMP.exr`: electrons per second at level 1
(channels R, G, B), with the variance of their own Monte Carlo error (R.var, G.var, B.var).
{maps}"""

UNKNOWN = """
The frames are not known to be simulated: there is no truth record.
"""


def readme(source: Source, chosen: Format, maps: Sequence[Map], licence: str) -> str:
    """The page for a capture in a format."""
    document = source.document
    first = source.capture.frames[0]
    truth = UNKNOWN
    if source.truth is not None:
        listed = [f"- `{known.file}` [{known.unit}]: {known.what}" for known in maps]
        truth = TRUTH.format(
            gain=source.truth["gain_dn_per_e"],
            black=source.truth["black_dn"],
            maps="\n".join(["", *listed, ""]) if listed else "",
        )
    return PAGE.format(
        camera=document.camera,
        frames=sum(frames.count for frames in source.capture.frames),
        shots=len(document.shot),
        width=first.width,
        height=first.height,
        pixels=document.pixels,
        bits=document.bits,
        cfa=f", colour filters {document.cfa}" if document.cfa else "",
        says=chosen.says,
        reading=chosen.reading.replace("FILE", "'frames/...'"),
        truth=truth,
        licence=licence,
    )
