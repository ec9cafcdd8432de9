"""A glossy coat by formula: what a rough dielectric adds to a matt colour, and takes from it.

    f = F(h) D(h) G / (4 cos_i cos_o)  +  rho / pi  T(i) T(o) / (n^2 (1 - R_in))

The first term is the highlight: Fresnel reflection F at those facets of a Beckmann surface D that
mirror the lamp into the lens, shadowed by Smith's G [1]. The second is the colour below: light that
is let through on its way in and out, T, and R_in, what the surface
throws back on the inside of all that strikes it. Reflections below the surface count for white
light, so that the coat is linear in the reflectance rho, as in Mitsuba's `roughplastic`.

[1] B. Walter et al., Microfacet models for refraction through rough surfaces, EGSR 2007.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from scenes.chart import Gloss

Array = NDArray[np.float64]

POLAR, ROUND = 96, 96
"""Nodes over the slope of the facets and around it; the albedo is then right to 1e-4."""
ANGLES = 128
"""Entries of the table of albedos against the cosine."""


def fresnel(cosine: Array, index: float) -> Array:
    """The part of unpolarised light that is reflected, coming from the side of index 1."""
    inside2 = 1 - (1 - cosine**2) / index**2
    inside = np.sqrt(np.maximum(inside2, 0.0))
    s = (cosine - index * inside) / (cosine + index * inside)
    p = (index * cosine - inside) / (index * cosine + inside)
    return np.where(inside2 > 0, (s**2 + p**2) / 2, 1.0)


def facets(cosine: Array, roughness: float) -> Array:
    """Beckmann's density of facets whose normal makes an angle with that of the surface, 1/sr."""
    squared = cosine**2
    slope2 = (1 - squared) / (squared * roughness**2)
    return np.asarray(np.exp(-slope2) / (np.pi * roughness**2 * squared**2))


def seen(cosine: Array, roughness: float) -> Array:
    """Smith's part of the facets that is not hidden at an angle, Walter's rational fit (35e-4)."""
    tangent = np.sqrt(np.maximum(1 - cosine**2, 1e-12)) / cosine
    a = 1 / (roughness * tangent)
    fit = (3.535 * a + 2.181 * a**2) / (1 + 2.276 * a + 2.577 * a**2)
    return np.where(a < 1.6, fit, 1.0)


def highlight(incoming: Array, outgoing: Array, facing: Array, gloss: Gloss) -> Array:
    """The highlight's part of the BRDF in 1/sr, for unit vectors (..., 3) away from the surface."""
    half = incoming + outgoing
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    cos_i, cos_o, cos_h = incoming @ facing, outgoing @ facing, half @ facing
    reflected = fresnel((incoming * half).sum(axis=-1), gloss.index)
    shown = seen(cos_i, gloss.roughness) * seen(cos_o, gloss.roughness)
    return np.asarray(reflected * facets(cos_h, gloss.roughness) * shown / (4 * cos_i * cos_o))


def below(cos_i: Array, cos_o: Array, gloss: Gloss) -> Array:
    """What the coat leaves of the BRDF of the matt colour below, as a factor."""
    cosines, let_in, thrown_back = _through(gloss)
    through = np.interp(np.stack([cos_i, cos_o]), cosines, let_in)
    return np.asarray(through[0] * through[1] / (gloss.index**2 * (1 - thrown_back)))


def made_good(gloss: Gloss) -> float:
    """By how much the reflectances given to Mitsuba have to be raised.

    Its `roughplastic` takes the plain mean of 64 samples, 0 among them, for the integral of what is
    thrown back inside: 1/64 too little, and the colour below 1 to 2 % too dark.
    """
    thrown_back = _through(gloss)[2]
    return (1 - thrown_back * 63 / 64) / (1 - thrown_back)


@functools.lru_cache(maxsize=8)
def _through(gloss: Gloss) -> tuple[Array, Array, float]:
    """Cosines, the part let through from outside, and what is thrown back inside of all light."""
    cosines = np.linspace(0.0, 1.0, ANGLES)
    slanted = np.maximum(cosines, 1e-3)
    let_in = np.array([albedos(c, gloss.roughness, gloss.index)[1] for c in slanted])
    inside = np.array([albedos(c, gloss.roughness, 1 / gloss.index)[0] for c in slanted])
    return cosines, let_in, 2 * float(np.trapezoid(inside * cosines, cosines))


def albedos(cosine: float, roughness: float, index: float) -> tuple[float, float]:
    """All that is reflected, and all that is let through, of light at one angle.

    Over the facets, F D G |i.h| / cos_i d(h) and the same with 1 - F. The slope t of the facets has
    the density exp(-t^2 / a^2) 2 t / a^2, so that t^2 / a^2 has an exponential one. What the facets
    throw on one another is lost; the two do not quite sum to 1.
    """
    at, weight = np.polynomial.legendre.leggauss(POLAR)
    spread = -np.log1p(-(at + 1) / 2 * (1 - 1e-9))
    tangent = roughness * np.sqrt(spread)[:, None]
    angle = (np.arange(ROUND) + 0.5)[None, :] * 2 * np.pi / ROUND
    up = 1 / np.sqrt(1 + tangent**2)
    dot = np.sqrt(1 - cosine**2) * tangent * up * np.cos(angle) + cosine * up
    lit = dot > 0
    facing = np.where(lit, dot, 1.0)
    reflected = fresnel(facing, index)
    weighed = np.where(lit, seen(np.array(cosine), roughness) * dot / (cosine * up), 0.0)
    # The ray that goes out mirrors the one that comes in, in the facet; or is refracted by it.
    out = 2 * facing * up - cosine
    inside = np.sqrt(np.maximum(1 - (1 - facing**2) / index**2, 0.0))
    down = cosine / index - (facing / index - inside) * up
    parts = []
    for share, leaving in ((reflected, out), (1 - reflected, down)):
        shown = np.where(leaving > 0, seen(np.maximum(leaving, 1e-6), roughness), 0.0)
        parts.append(float(((weighed * share * shown).mean(axis=1) * weight / 2).sum()))
    return parts[0], parts[1]
