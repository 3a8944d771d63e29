"""Which rows are written: those that a law which never moves backwards keeps by itself are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthesis.catalogue.constraints import PointInequalities
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales, Tightening
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.conic.tangent_cuts import cut_block
from synthesis.optimise.problem.grid import Grid, uniform_grid
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.scenes import (
    PLAIN,
    angles,
    dwell,
    even,
    fall,
    jerk,
    problem,
    rise,
    scene,
    velocity,
)  # fmt: skip

LIMITS = (angles(23.0, 41.7), velocity(1.83, 71.7), jerk(67.0, 71.7))
SCENES: dict[str, tuple[DesignSpec, int]] = {
    # rise and return have a pressure angle and a velocity that bind one way; the rest is one row
    "between dwells": (scene((rise(71.7), dwell(23.9), fall(83.3), dwell(181.1)), *LIMITS), 4),
    "a small angle one way": (
        scene((rise(71.7), dwell(23.9), fall(83.3), dwell(181.1)), angles(4.0, 73.0)), 2,
    ),
    "turning at the top": (scene((rise(131.7), fall(97.3), dwell(131.0)), *LIMITS), 4),
    # where the follower is in motion at the low end its velocity there is not known to be 0
    "steps without rest": (
        scene((rise(61.3, 11.9), rise(77.9, 15.4), dwell(41.7), fall(99.1), dwell(80.0)), *LIMITS),
        4,
    ),
    "overshoot": (
        scene((rise(71.7, overshoot=True), dwell(23.9), fall(83.3), dwell(181.1)), *LIMITS), 2,
    ),
}  # fmt: skip


def plan_of(spec: DesignSpec) -> ConicModel:
    question = problem(spec)
    return formulate(question, even(question, 14))


@pytest.mark.parametrize("name", SCENES)
def test_what_is_left_out_holds_all_the_same(name: str) -> None:
    spec, short = SCENES[name]
    model = plan_of(spec)
    written = [b for b in model.blocks if b.kind == "point" and not b.alpha[2:].any()]
    assert sum(len(block.rhs) == 1 for block in written) == short
    laws, size = model.recover(solve(model.program).x)
    tried = 0
    for k, segment in enumerate(model.problem.free):
        s = segment.with_law(laws[k].curve()).placed()
        theta = segment.start + segment.angle * model.grids[k].points
        values = s.derivatives(theta)
        for row in model.problem.limit_rows(segment):
            if not any(row.coefficients[2:]):
                share = sum(a * v for a, v in zip(row.size, size, strict=False))
                worst = float(np.max(np.array(row.coefficients) @ values)) + share - row.upper
                assert worst <= 1e-7 * model.scales.size
                tried += 1
    assert tried == len(written)


def test_an_equality_is_two_inequalities() -> None:
    rng = np.random.default_rng(9)
    laws, c = rng.standard_normal((5, 7)), rng.standard_normal(7)
    alpha, x = np.array([0.0, 1.3, 0.0, 0.0]), np.linspace(0.1, 0.5, 5)
    whole = LinearBlock(
        "point", 0, laws, x, alpha, np.zeros(0), 0.0, laws @ c, "held", exact=True
    )  # fmt: skip
    below, above = whole.inequalities()
    for off in (0.0, 1e-3, -1e-3):
        kept = [
            each.law_matrix @ c <= each.rhs + 1e-12
            for each in (replace(b, rhs=b.rhs + s * off) for b, s in ((below, 1), (above, -1)))
        ]
        assert (below.exact, above.exact) == (False, False)
        assert (np.all(kept[0]), np.all(kept[1])) == (off >= 0.0, off <= 0.0)
    assert below.alpha.tolist() == (-above.alpha).tolist() == alpha.tolist()
    moved = c + rng.standard_normal(7)
    assert np.all((below.law_matrix @ moved > below.rhs) | (above.law_matrix @ moved > above.rhs))


def test_points_ascend_only_where_each_is_beyond_the_one_before() -> None:
    for x, ascending in (((0.1, 0.2, 0.3), True), ((0.1, 0.2, 0.2), False), ((0.1,), False)):
        rows = LinearBlock.of_size(np.ones(2), np.ones(len(x)), "size")
        assert replace(rows, x=np.array(x)).ascending == ascending


def test_grids_alike_are_one_with_one_set_of_tables() -> None:
    rising, falling = plan_of(SCENES["between dwells"][0]).problem.free
    first, second = uniform_grid(rising, 17), uniform_grid(falling, 17)
    assert first is second
    assert first.basis_table(1) is second.basis_table(1)
    np.testing.assert_array_equal(first.basis_table(2), first.space.basis(first.points, 2))
    assert first.with_points(np.array([0.013])).basis_table(0).shape[0] == len(first.points) + 1


@pytest.mark.filterwarnings("error")
def test_a_cut_of_constants_alone_is_its_own_unit() -> None:
    """Where a limit changes neither with the motion nor with the size, its tangent is a number."""
    question = problem(scene(PLAIN, angles(30.0, 45.0), jerk(60.0, 71.7)))
    (segment, *_), points = question.free, np.array([0.2, 0.7])
    coefficients = np.zeros((4, 2))
    coefficients[2, 1] = -1.7
    cuts = PointInequalities(coefficients, np.zeros((2, 2)), np.array([0.31, 0.4]))
    grid = Grid(uniform_grid(segment, 9).space, points)
    block = cut_block(cuts, "tangent", 0, segment, grid, Scales(1.0, 1.0), Tightening())
    assert block.rhs[0] == pytest.approx(0.31)
    assert np.all(np.isfinite(block.rhs))
    assert not np.any(block.alpha[:, 0])
