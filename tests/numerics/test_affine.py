"""Affine models hold what their formulas take on their boxes, and close in with the square."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from synthesis.numerics.affine import NARROW, Affine, minorant_plane, positive

FORMULAS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "product": lambda x, y, z: (x - 1.7 * y) * (z * y - 0.31),
    "quotient": lambda x, y, z: (x * y - 2.3) / (z + 1.9) - 3.1 / (x + 4.0),
    "root": lambda x, y, z: np.sqrt(x * x + y * y + 0.7) / np.sqrt(2.5 + z),
    "waves": lambda x, y, z: np.sin(x * y) / np.cos(0.4 * z) - np.cos(x + y),
    "largest": lambda x, y, z: np.maximum(x * y, z - 0.2) - np.minimum(y, np.abs(x - z)),
    "NumPy's numbers": lambda x, y, z: (
        np.float64(1.3) * np.negative(x) - np.float64(0.7) / (np.float64(2.9) + y)
        - (np.float64(0.4) - z)
    ),
}  # fmt: skip
SMOOTH = ("product", "quotient", "root", "waves", "NumPy's numbers")


def boxes(width: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    middle = np.random.default_rng(11).uniform(-1.3, 1.3, (count, 3))
    return middle - 0.5 * width, middle + 0.5 * width


@pytest.mark.parametrize("name", FORMULAS)
@pytest.mark.parametrize("width", [0.9, 0.13, 1e-3])
def test_ranges_are_held(name: str, width: float) -> None:
    lo, hi = boxes(width, 40)
    with np.errstate(all="ignore"):
        model = FORMULAS[name](*Affine.variables(lo, hi))
    share = np.random.default_rng(5).random((300, 1, 3)).round(1)  # corners and edges among them
    x, y, z = np.moveaxis(lo + share * (hi - lo), -1, 0)
    values = FORMULAS[name](x, y, z)
    known = np.isfinite(model.rem)
    assert np.count_nonzero(known) > 20
    assert np.all((values >= model.lower)[:, known])
    assert np.all((values <= model.upper)[:, known])
    line = model.c + np.einsum("dn,knd->kn", model.g, 2.0 * share - 1.0)
    assert np.all((np.abs(values - line) <= model.rem)[:, known])


@pytest.mark.parametrize("name", SMOOTH)
def test_remainders_shrink_with_the_square(name: str) -> None:
    wide, narrow = (FORMULAS[name](*Affine.variables(*boxes(width, 40))) for width in (2e-2, 2e-3))
    assert np.all(narrow.rem <= wide.rem / 80.0)


def test_where_a_divisor_may_vanish_nothing_is_said() -> None:
    (x,) = Affine.variables(np.array([[-0.1], [0.2]]), np.array([[0.3], [0.4]]))
    with np.errstate(all="ignore"):
        found = 1.0 / x
    assert not np.isfinite(found.rem[0])
    assert found.rem[1] < 1.0


@pytest.mark.parametrize("name", SMOOTH[:-1])
def test_a_plane_lies_below_its_function_and_near_it(name: str) -> None:
    lost = []
    for width in (0.08, 0.04):
        lo, hi = (ends.T for ends in boxes(width, 40))
        at = lo + np.array([[0.3], [0.5], [0.9]]) * (hi - lo)
        below = minorant_plane(FORMULAS[name], lo, hi, at, (3, 2, 2))
        assert below is not None
        slopes, height = below
        share = np.random.default_rng(5).random((300, 3, 1)).round(1)
        points = lo + share * (hi - lo)
        above = FORMULAS[name](*np.moveaxis(points, 1, 0)) - np.sum(slopes * points, axis=1)
        assert np.all(above >= height)
        lost.append(float(np.max(np.min(above, axis=0) - height)))
    assert lost[1] < 0.35 * lost[0]


def test_no_plane_is_known_where_a_function_has_a_pole() -> None:
    lo, hi = np.array([[-0.2, 0.4]]), np.array([[0.3, 0.5]])
    assert minorant_plane(lambda x: 1.0 / x, lo, hi, 0.5 * (lo + hi), (4,)) is None
    assert minorant_plane(lambda x: 1.0 / x, lo[:, 1:], hi[:, 1:], hi[:, 1:], (4,)) is not None


def test_a_divisor_that_has_to_be_positive_is_unknown_where_it_is_not() -> None:
    lo, hi = np.array([[-0.4, -0.2, 0.4]]), np.array([[-0.3, 0.3, 0.5]])
    for k in range(3):
        one, two = lo[:, k : k + 1], hi[:, k : k + 1]
        found = minorant_plane(lambda x: 1.0 / positive(x), one, two, 0.5 * (one + two), (2,))
        assert (found is not None) == (k == 2)


def test_narrow_boxes_are_cut_into_fewer_cells() -> None:
    """A cell as narrow as that loses next to nothing, and each costs as much."""
    sizes = list[int]()

    def counted(x: Any, y: Any) -> Any:
        if isinstance(x, Affine):
            sizes.append(x.c.size)
        return x * y + np.sin(x * 3.0)

    wide = np.array([[0.1, 0.3], [0.4, 0.2]])
    for width, cells in ((0.2, 12), (0.9 * NARROW, 1), (1.5 * NARROW, 4)):
        low, high = wide, wide + width
        assert minorant_plane(counted, low, high, 0.5 * (low + high), (4, 3)) is not None
        assert sizes.pop() == 2 * cells
