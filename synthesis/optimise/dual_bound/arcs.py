"""Multipliers along arcs on which a limit binds: moved so that ψ vanishes there.

Along such an arc the ideal law's control lies between its caps, so that ψ of the best multipliers
is zero all along. Those of a program over splines have it right on average over each knot interval;
what is left of ψ in between changes sign, and the bound pays for its size. So the multipliers of an
arc are chosen anew, those for which ψ is least in the mean square. What they come to in all that
lies before the arc, and in the size, stays as it is. Of an inequality they are not negative, and so
as valid as any; of a value that is held on a window they may have either sign.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import factorial
from typing import Literal

import numpy as np
from scipy.optimize import nnls

from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.lagrangian import Lagrangian, sums_at_start
from synthesis.optimise.dual_bound.row_functionals import (
    RowFunctional,
    Terms,
    distribute_to_intervals,
)
from synthesis.optimise.dual_bound.switching import Switching

ACCELERATION = 2  # order of the derivative
BINDS = 1e-5  # of the largest multiplier: a smaller one is of a row that does not bind
SHORTEST = 4  # multipliers of an arc: fewer are all used up by what has to stay as it is
KEPT = 1e3  # weight of what stays as it is, relative to that of ψ
SAMPLES = 3  # of ψ between two multipliers
WINDOW_NODES = 33  # Chebyshev points of a window on which its multipliers are redistributed
WINDOW_SAMPLES = 3  # between two of them, at which ψ is made small

HatKind = Literal["falling", "rising"]
Function = Callable[[Array], Array]


def density_terms(
    one: RowFunctional, nodes: Array, mass: Array, psi: Sequence[Switching] = ()
) -> Terms:
    """Masses (n,) at ascending nodes (n,) as rows with densities linear in between.

    ``psi``: of every free law, what all multipliers come to as they stand; where it is given, the
    masses are moved along their arcs.
    """
    if not len(nodes):
        return []
    if psi and one.block.segment is not None:
        mass = flatten(one, nodes, mass, psi[one.block.segment])
    own = np.concatenate(distribute_to_intervals(nodes, mass))
    return [(one.hat_rows(nodes).select(own != 0.0), own[own != 0.0])]


def with_densities_of_control(model: ConicModel, z: Array) -> tuple[ConicModel, Array] | None:
    """A model and its multipliers (m,), those of rows on s'' and the size densities; None: none.

    Where s'' is the control, a row on it at a point says nothing of a law. But its limit holds
    almost everywhere, and so with any density that is not negative. What the points have goes to
    the knots beside them; between these the density is linear.
    """
    at = model.program.equalities
    blocks, parts = list[LinearBlock](), [z[:at]]
    for block in model.blocks:
        own, at = z[at : at + len(block.rhs)], at + len(block.rhs)
        uniform = block.alpha.ndim == 1 and block.size.ndim == 1 and block.spans is None
        of_both = block.orders[-1:] == (ACCELERATION,) and np.any(block.size)
        if not (of_both and uniform) or block.segment is None:
            blocks.append(block)
            parts.append(own)
            continue
        breaks = model.grids[block.segment].space.breaks
        left = np.clip(np.searchsorted(breaks, block.x, "right") - 1, 0, len(breaks) - 2)
        share = (block.x - breaks[left]) / np.diff(breaks)[left]
        mass = np.asarray(np.bincount(left, (1.0 - share) * own, len(breaks)), dtype=float)
        mass += np.bincount(left + 1, share * own, len(breaks))
        spans = np.stack([breaks[:-1], breaks[1:]], axis=1)
        rhs = np.full(len(spans), np.max(block.rhs))
        hats: tuple[tuple[HatKind, Array], ...] = tuple(
            zip(("falling", "rising"), distribute_to_intervals(breaks, mass), strict=True)
        )
        for kind, masses in hats:
            x = spans.mean(axis=1)
            blocks.append(replace(block, kind=kind, law_matrix=None, x=x, spans=spans, rhs=rhs))
            parts.append(masses)
    if len(blocks) == len(model.blocks):
        return None
    program = replace(model.program, inequalities=sum(len(block.rhs) for block in blocks))
    changed = replace(model, blocks=tuple(blocks), program=program)
    return changed, np.concatenate([*parts, z[at:]])


def flatten(one: RowFunctional, nodes: Array, mass: Array, psi: Function) -> Array:
    """Masses (n,) ≥ 0 at ascending nodes (n,), moved along every arc so that ψ is small there.

    ``psi``: what they come to as they are, with all else.
    """
    result, binding = mass.copy(), np.flatnonzero(mass > BINDS * np.max(mass))
    for arc in np.split(binding, np.flatnonzero(np.diff(binding) > 1) + 1):
        if len(arc) < SHORTEST:
            continue
        # The arc with a node more at either end, and what a mass at each of its nodes comes to.
        first = max(arc[0] - 1, 0)
        near = nodes[first : arc[-1] + 2]
        units = np.eye(len(near))[arc - first]
        own = np.stack([np.concatenate(distribute_to_intervals(near, unit)) for unit in units], 1)
        rows = one.hat_rows(near)
        # 1. ψ at samples of the arc, as a function of its masses.
        tau, width = (each.ravel() for each in gauss_points(near, SAMPLES))
        effect, weight = rows.psi(tau) @ own, np.sqrt(width)
        wanted = effect @ mass[arc] - psi(tau)
        # 2. What has to stay: the polynomial that ψ gets before the arc, and factors of the size.
        before = sums_at_start((rows.x - near[0])[:, None], rows.weights[:, None])
        kept = np.hstack([before, rows.size]).T @ own
        kept = kept[np.any(kept, axis=1)]
        kept *= KEPT * np.linalg.norm(effect) / np.max(np.abs(kept), axis=1, keepdims=True)
        # 3. Least squares over masses that are not negative.
        table = np.vstack([weight[:, None] * effect, kept])
        try:
            result[arc] = nnls(table, np.append(weight * wanted, kept @ mass[arc]))[0]
        except RuntimeError:  # too many iterations: they stay as they are
            continue
    return result


def redistribute_window_multipliers(lagrangian: Lagrangian) -> None:
    """Add multipliers to equalities along windows that make ψ small there: they are free."""
    order = lagrangian.order
    for block in lagrangian.model.equality_blocks:
        k = int(np.flatnonzero(block.alpha)[0])
        if block.spans is None or block.segment is None or len(block.x) == 1 or k >= order:
            continue
        part = (float(block.spans[0, 0]), float(block.spans[-1, 1]))
        psi = lagrangian.psi()[block.segment]
        x, mass = window_multipliers(psi, block.x, part, float(block.alpha[k]), order - 1 - k)
        lagrangian.add_constant(-np.sum(mass) * block.rhs[0])
        weights = mass[None, :, None] * block.alpha[:order]
        lagrangian.add_functionals(block.segment, x, weights)


def window_multipliers(
    psi: Switching, x: Array, part: tuple[float, float], factor: float, degree: int
) -> tuple[Array, Array]:
    """Masses to add to a held derivative's multipliers that make ψ small on its window.

    Where a derivative is held, the control is determined and ψ should vanish. The multipliers of a
    spline's rows make it small only on average over the splines; between them it oscillates, and
    the bound pays for the area. Masses without moments up to ``degree`` leave ψ as it is elsewhere.

    Args:
        psi: ψ as it stands. x: (r,) points of the present multipliers. part: the window.
        factor: of the derivative in its rows.
        degree: a mass at x contributes factor (x − τ)^degree / degree! to ψ, for τ < x.

    Returns:
        (n,) points and (n,) masses, whose moments up to that degree vanish.
    """
    low, high = part
    chebyshev = 0.5 - 0.5 * np.cos(np.pi * np.arange(WINDOW_NODES) / (WINDOW_NODES - 1))
    nodes = np.unique(np.clip(np.append(x, low + (high - low) * chebyshev), low, high))
    width = np.diff(nodes)
    shares = (np.arange(WINDOW_SAMPLES) + 0.5) / WINDOW_SAMPLES
    tau = (nodes[:-1, None] + width[:, None] * shares).ravel()
    weight = np.sqrt(np.repeat(width / (high - low), WINDOW_SAMPLES))
    unit = (high - low) ** degree / factorial(degree)
    reach = np.maximum(nodes - tau[:, None], 0.0) / (high - low)
    effect = weight[:, None] * (reach**degree if degree else (nodes > tau[:, None]))
    scaled = (nodes - low) / (high - low)
    moments = np.vander(scaled, degree + 1, increasing=True).T
    *_, directions = np.linalg.svd(moments)
    free = directions[degree + 1 :].T  # masses without moments
    result, *_ = np.linalg.lstsq(effect @ free, -weight * psi(tau), rcond=1e-10)
    return nodes, (free @ result) / (factor * unit)
