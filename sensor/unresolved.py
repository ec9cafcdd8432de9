"""Light between the pixels of a picture, of which the picture does not tell all.

An edge lies somewhere in a pixel, and the mean of the pixel does not say where. By smooth light a
place between pixels shows what cubic convolution makes of them; by light that is even within each
pixel, what a straight line does. Beside an edge the truth is neither: it is as far from the cubic
as L times the straight line is, where L differs from edge to edge. Of hard edges its root mean
square, over all places in a pixel and all shifts, is 2.13; of edges softened by 0.3, 0.6 and 1 px
it is 1.5, 0.8 and 0.4.
"""

from __future__ import annotations

from typing import Any

import drjit as dr

from sensor.effect import switch
from sensor.image_plane import constant, resampled
from sensor.signal import Signal
from sensor.stream import Stream

OF_HARD_EDGES = 2.13
"""Root mean square of L."""


def unresolved_edges() -> Any:
    """Declare how light lies between the pixels of a picture: an effect's parameter."""
    return switch(
        0.0,
        starts=(0.0,),
        doc="light between pixels: 0 where it is smooth, 1 where edges lie anywhere in a pixel",
    )


def moved(signal: Signal, stream: Stream, down: Any, right: Any, unresolved: float) -> Signal:
    """A rate as it is between its pixels, where edges of a body's own lie if any do.

    Edges of panels lie along rows and columns, so that each of these has an L of its own. How hard
    the edges of a scene are nobody knows: each body's are so many times as hard as can be, evenly
    from 0 to 1.

    Args:
        signal: a rate (f, H, W, 3).
        stream: of the effect.
        down, right: where to look, in px from the centre: tensors that broadcast to (1, H, W, 3).
        unresolved: 0 or 1; see there.
    """
    if unresolved == 0.0:
        return signal.replace(resampled(signal, down, right))
    height, width = signal.shape[1:3]
    body = stream.body
    hard = constant(signal, OF_HARD_EDGES) * body.uniform(1, 1, 1, use="hard")
    dr.eval(hard)  # one number: left open it takes the size of what it is first multiplied by
    rows = hard * body.normal(height, 1, 1, use="rows")
    columns = hard * body.normal(1, width, 1, use="columns")
    return signal.replace(resampled(signal, down, right, straight=(rows, columns)))
