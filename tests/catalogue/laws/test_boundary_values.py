"""Laws between states that are not rests: the 16 tasks of VDI 2143, and straight lines on top.

References: the closed form of the least mean square jerk, a brute-force search for a better
polynomial, and the boundary values themselves.
"""

from itertools import product

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.base import TASKS
from synthesis.catalogue.laws.boundary_polynomial import hermite
from synthesis.numerics.piecewise import Piecewise

# unspecial numbers: g' and g'' at the start and at the end, zero where the task says so
V0, A0, V1, A1 = 0.7310, -3.1270, 1.4130, 2.2690
ENDS = {
    "R": ((0.0, 0.0), (0.0, 0.0)),
    "G": ((V0, 0.0), (V1, 0.0)),
    "U": ((0.0, A0), (0.0, A1)),
    "B": ((V0, A0), (V1, A1)),
}
X = np.linspace(0.0, 1.0, 401)


def least_mean_square_jerk(D: float, v0: float, a0: float, v1: float, a1: float) -> float:
    """∫ j² of the best motion with these boundary values."""
    return (
        720 * D**2 - 120 * D * (a0 - a1) - 720 * D * (v0 + v1) + 9 * (a0**2 + a1**2) - 6 * a0 * a1
        + 72 * (a0 * v0 - a1 * v1) + 48 * (a0 * v1 - a1 * v0) + 192 * (v0**2 + v1**2)
        + 336 * v0 * v1
    )  # fmt: skip


def mean_square(curve: Piecewise, order: int) -> float:
    nodes, weights = np.polynomial.legendre.leggauss(12)
    total = 0.0
    for low, high in zip(curve.breaks[:-1], curve.breaks[1:], strict=True):
        x = low + (high - low) * (nodes + 1.0) / 2.0
        total += float(np.sum(weights * curve(x, order) ** 2) * (high - low) / 2.0)
    return total


def brute_force(known: tuple[float, ...], order: int, degree: int = 12) -> float:
    """Least ∫ (g^(order))² over polynomials of a degree with these values at 0 and at 1."""
    m = len(known) // 2
    powers = [Polynomial.basis(k) for k in range(degree + 1)]
    rows = [[float(p.deriv(j)(x)) if j else float(p(x)) for p in powers]
            for x in (0.0, 1.0) for j in range(m)]  # fmt: skip
    steep = [p.deriv(order) for p in powers]
    gram = np.array([[float((a * b).integ()(1.0)) for b in steep] for a in steep])
    system = np.block([[2.0 * gram, np.array(rows).T], [np.array(rows), np.zeros((2 * m, 2 * m))]])
    rhs = np.concatenate([np.zeros(degree + 1), known])
    c = np.linalg.lstsq(system, rhs, rcond=1e-15)[0][: degree + 1]
    return float(c @ gram @ c)


def test_the_tasks_are_vdi_2143s_sixteen() -> None:
    assert len(set(TASKS)) == 16
    assert LAWS["polynomial_5"].tasks == LAWS["polynomial_7"].tasks == TASKS


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("kind", ["polynomial_5", "polynomial_7"])
def test_every_task_is_met(kind: str, task: str) -> None:
    start, end = ENDS[task[0]][0], ENDS[task[2]][1]
    curve = LAWS[kind].with_end_derivatives("rise", start, end)
    at_start, at_end = curve.derivatives([0.0, 1.0], 3).T
    assert at_start[:3] == pytest.approx([0.0, *start], abs=1e-15)
    assert at_end[:3] == pytest.approx([1.0, *end], abs=2e-14)
    if kind == "polynomial_7":
        assert [at_start[3], at_end[3]] == pytest.approx([0.0, 0.0], abs=2e-12)
    inner = curve.derivatives([0.5], 5, "left") - curve.derivatives([0.5], 5, "right")
    assert np.abs(inner[:, 0]) == pytest.approx(np.zeros(6), abs=1e-9)


@pytest.mark.parametrize("task", TASKS)
def test_degree_5_has_the_least_mean_square_jerk(task: str) -> None:
    (v0, a0), (v1, a1) = ENDS[task[0]][0], ENDS[task[2]][1]
    reached = mean_square(hermite((0.0, v0, a0), (1.0, v1, a1)), 3)
    assert reached == pytest.approx(least_mean_square_jerk(1.0, v0, a0, v1, a1), rel=1e-12)
    assert reached == pytest.approx(brute_force((0.0, v0, a0, 1.0, v1, a1), 3), rel=1e-7)


@pytest.mark.parametrize("task", ["R-R", "G-U", "B-G", "B-B"])
def test_degree_7_has_the_least_mean_square_snap(task: str) -> None:
    start, end = ENDS[task[0]][0], ENDS[task[2]][1]
    reached = mean_square(LAWS["polynomial_7"].with_end_derivatives("rise", start, end), 4)
    assert reached == pytest.approx(brute_force((0.0, *start, 0.0, 1.0, *end, 0.0), 4), rel=1e-7)


def test_a_polynomial_takes_what_is_not_asked_for_as_rest() -> None:
    law = LAWS["polynomial_5"]
    curve = law.with_end_derivatives("return", (None, A0), (V1, None))
    assert curve.derivatives([0.0], 2)[1:, 0] == pytest.approx([0.0, A0], abs=1e-15)
    assert curve.derivatives([1.0], 2)[1:, 0] == pytest.approx([V1, 0.0], abs=1e-14)


LINED = [kind for kind, law in LAWS.items() if law.tasks == ("R-R", "G-G")]


def test_which_laws_run_between_constant_velocities() -> None:
    jumping = {"parabolic", "simple_harmonic", "cubic_2_3", "constant_velocity"}
    turning = {"double_harmonic", "kloomok_muffley_8", "polynomial_3_4_5_6"}
    assert set(LAWS) - set(LINED) == jumping | turning | {"polynomial_5", "polynomial_7"}
    assert all(LAWS[kind].tasks == () for kind in jumping)


@pytest.mark.parametrize(("kind", "c"), [*product(LINED, [0.4321, 1.2345])])
def test_a_straight_line_on_top_of_a_law_between_rests(kind: str, c: float) -> None:
    """g = (1 − c) f + c x: typed here with f alone."""
    law = LAWS[kind].model_copy(update={"inflection": 0.41})
    f, g = law.curve("rise"), law.with_end_derivatives("rise", (c, 0.0), (c, None))
    expected = (1.0 - c) * f.derivatives(X)
    expected[0] += c * X
    expected[1] += c
    peaks = np.abs(expected).max(axis=1)
    assert np.abs(g.derivatives(X) - expected).max(axis=1) == pytest.approx(
        np.zeros(4), abs=3e-14 * peaks.max()
    )
    assert np.all(g.derivatives([0.0, 1.0], 2)[1] == pytest.approx([c, c], abs=1e-14))
    assert law.with_end_derivatives("rise", (None, None), (0.0, None)) is f
