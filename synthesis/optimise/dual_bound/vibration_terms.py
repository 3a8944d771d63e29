"""Limits on residual vibration as terms of the Lagrangian.

The two rows of a run are integrals of the law against a damped wave, so that ψ gets a wave. In
pieces of a quarter of a radian it is a polynomial of degree 4 but for an error that is bounded, and
that the dual bound pays for. With multipliers y the ring |W| ≤ r is the valid row y · W ≤ ‖y‖ r,
whatever y (Cauchy and Schwarz).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.row_functionals import Terms, WeightedRows
from synthesis.optimise.problem.residual_vibration import VibrationTerm, switching_contribution


def vibration_terms(
    model: ConicModel, order: int, multipliers: Sequence[tuple[VibrationTerm, Array]], sets: int = 1
) -> tuple[Terms, Array]:
    """Limits on residual vibration, with multipliers y of their two rows: (q, 2) each.

    ``order``: m, of the control. ``sets``: q.

    Returns:
        the terms, and how far the laws' true ψ may be from theirs: (q, laws).
    """
    sizes = len(model.problem.sizing.bounds)
    terms, error = Terms(), np.zeros((sets, len(model.grids)))
    for vibration, y in multipliers:
        if not y.any():
            continue
        rhs = np.array([vibration.radius, *-vibration.shift])
        length = np.linalg.norm(y, axis=1, keepdims=True)
        terms.append((WeightedRows.of_size(rhs, np.zeros((3, sizes))), np.hstack([length, y])))
        # ψ is linear in y: the parts of its real and its imaginary row, each times its multiplier
        for share in vibration.law_terms:
            for axis, unit in enumerate(np.eye(2)):
                part, mass = switching_contribution(share, unit, order), y[:, axis, None]
                count = len(part.spans)
                weights = np.zeros((count, order))
                weights[0] = part.initial
                rows = WeightedRows(
                    share.position, np.zeros(count), weights, np.zeros(count),
                    np.zeros((count, sizes)), signed=True, spans=part.spans, poly=part.poly,
                )  # fmt: skip
                terms.append((rows, np.repeat(mass, count, axis=1)))
                error[:, share.position] += part.error * np.abs(mass[:, 0])
    return terms, error
