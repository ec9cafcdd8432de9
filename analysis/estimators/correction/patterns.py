"""Fixed patterns of all shots of a panel at once: FPN and PRNU from covariances.

A site has one offset o and one response 1 + p for good. Less its shading and less black, its level
in shot s is y_s = o + p I_s + e_s, with e_s what averaging N frames leaves of the noise in time.
Over the sites of a lattice the shots therefore covary as

    Sigma_st = F + P <I_s I_t> + v_s [s = t],        F = fpn^2,  P = prnu^2,

with I = 0 in the dark and < > the mean over sites. After a shading fit the sums of products S with
their nu degrees of freedom are Wishart with that mean, and F and P follow by Fisher scoring, shots
and panels weighted as the likelihood has it. What averaging leaves in the diagonal is part of the
model and not of the pattern, and as the same pattern is in every shot, more shots make it clearer
but not more numerous: errors stay those of as many sites as there are.

One more term tests it: a pattern p (I + c / p), the paper's offset of equation (16), adds to first
order c sqrt(P) (<I_s> + <I_t>) between lit shots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.estimators.parts.panel_noise import Floats

ROUNDS = 12

CONVERGED = 1e-6
"""Relative step at which the iteration ends."""

SINGULAR = 1e5
"""Condition from which two terms cannot be told apart."""

LEAST_ERROR_DN2 = 1e-9
"""Floor of v_s, so that a pattern known without error can be inverted."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Covariances:
    """Covariances of one lattice over its shots.

    Attributes:
        products: S (shots, shots), sums of products over degrees of freedom.
        freedom: nu.
        light: <I_s I_t> (shots, shots) in DN^2, 0 for darks.
        level: <I_s> in DN, 0 for darks.
        lit: which shots are lit.
        error: v_s.
    """

    products: Floats
    freedom: int
    light: Floats
    level: Floats
    lit: NDArray[np.bool_]
    error: Floats


@dataclass(frozen=True, kw_only=True, eq=False)
class Patterns:
    """F in DN^2, P, and the offset c in DN, each with its standard error.

    None where the shots do not tell: F without darks, P without light, c with less than two
    levels. `chi2`, `freedom` and `chance` are the misfit of the covariances.
    """

    fpn_dn2: tuple[float, float] | None
    prnu2: tuple[float, float] | None
    offset_dn: tuple[float, float] | None
    chi2: float
    freedom: int
    chance: float


def fit_patterns(panels: list[Covariances]) -> Patterns | None:
    """Fit F and P to all lattices of a channel; None where even those cannot be told apart."""
    lit = any(panel.lit.any() for panel in panels)
    dark = any(not panel.lit.all() for panel in panels)
    terms = 2 if lit else 1
    if not panels or _singular(_score(panels, np.ones(terms), terms)[1]):
        return None
    theta = _start(panels, terms)
    for _ in range(ROUNDS):
        score, information = _score(panels, theta, terms)
        new = np.maximum(theta, 0.0) + np.linalg.solve(information, score)
        done = np.all(np.abs(new - theta) <= CONVERGED * np.abs(theta))
        theta = new
        if done:
            break
    score, information = _score(panels, theta, terms)
    se = np.sqrt(np.diag(np.linalg.inv(information)))
    offset = None
    if lit and theta[1] > 0:
        score, information = _score(panels, theta, 3)
        if not _singular(information):
            inverse = np.linalg.inv(information)
            offset = (float((inverse @ score)[2]), float(np.sqrt(inverse[2, 2])))
    chi2, entries = _misfit(panels, theta)
    freedom = entries - terms
    return Patterns(
        fpn_dn2=(float(theta[0]), float(se[0])) if dark else None,
        prnu2=(float(theta[1]), float(se[1])) if lit else None,
        offset_dn=offset,
        chi2=chi2,
        freedom=freedom,
        chance=float(stats.chi2.sf(chi2, freedom)) if freedom > 0 else 1.0,
    )


def _singular(information: Floats) -> bool:
    """Whether a matrix of information does not hold all its terms."""
    scale = np.sqrt(np.diag(information))
    if not scale.all():
        return True
    return bool(np.linalg.cond(information / np.outer(scale, scale)) > SINGULAR)


def _parts(panel: Covariances, theta: Floats, terms: int) -> tuple[Floats, list[Floats]]:
    """Sigma, and its derivatives by F, P and c."""
    ones = np.ones_like(panel.products)
    sigma = max(theta[0], 0.0) * ones + np.diag(np.maximum(panel.error, LEAST_ERROR_DN2))
    parts = [ones]
    if terms > 1 or len(theta) > 1:
        sigma = sigma + max(theta[1], 0.0) * panel.light
        parts.append(panel.light)
    if terms > 2:
        both = np.outer(panel.lit, panel.lit)
        parts.append(max(theta[1], 0.0) ** 0.5 * both * np.add.outer(panel.level, panel.level))
    return sigma, parts[:terms]


def _score(panels: list[Covariances], theta: Floats, terms: int) -> tuple[Floats, Floats]:
    score, information = np.zeros(terms), np.zeros((terms, terms))
    for panel in panels:
        sigma, parts = _parts(panel, theta, terms)
        inverse = np.linalg.inv(sigma)
        whitened = np.stack([inverse @ part for part in parts])
        excess = inverse @ (panel.products - sigma)
        half = panel.freedom / 2
        score += half * np.einsum("aij,ji->a", whitened, excess)
        information += half * np.einsum("aij,bji->ab", whitened, whitened)
    return score, information


def _start(panels: list[Covariances], terms: int) -> Floats:
    """Least squares of the products' entries, which the weights of the fit then improve."""
    design, points = [], []
    for panel in panels:
        _, parts = _parts(panel, np.zeros(terms), terms)
        weight = 1 / (np.sqrt(np.diag(panel.products)) + 1e-6)
        scale = np.outer(weight, weight)
        design.append(np.stack([(scale * part).ravel() for part in parts], axis=1))
        points.append((scale * (panel.products - np.diag(panel.error))).ravel())
    solution = np.linalg.lstsq(np.concatenate(design), np.concatenate(points), rcond=None)[0]
    return np.maximum(np.asarray(solution, dtype=np.float64), 1e-12)


def _misfit(panels: list[Covariances], theta: Floats) -> tuple[float, int]:
    """Sum over panels of nu/2 tr (Sigma^-1 (S - Sigma))^2, and the number of entries."""
    chi2, entries = 0.0, 0
    for panel in panels:
        sigma, _ = _parts(panel, theta, len(theta))
        excess = np.linalg.solve(sigma, panel.products - sigma)
        chi2 += panel.freedom / 2 * float(np.einsum("ij,ji->", excess, excess))
        entries += len(sigma) * (len(sigma) + 1) // 2
    return chi2, entries
