"""Triangulation of a body: a closed mesh without degenerate triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synthesis.machines.spatial.body import Body
from synthesis.numerics.piecewise import Array

Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface.

    Attributes:
        points: (n, 3) [mm]. triangles: (k, 3) points of each, counter-clockwise seen from outside.
            No two points are the same in single precision.
    """

    points: Array
    triangles: Whole

    @property
    def volume(self) -> float:
        """Enclosed volume [mm³], by the divergence theorem."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        return float(np.sum(a * np.cross(b, c)) / 6.0)


def triangulate(body: Body) -> Mesh:
    """The body's surface."""
    points, names = _merge_points(body)
    triangles = _cancel_folds(_triangles(body, names))
    mesh = Mesh(points, triangles)
    return mesh if mesh.volume > 0.0 else Mesh(points, triangles[:, ::-1])


def _merge_points(body: Body) -> tuple[Array, Whole]:
    """Distinct points, and the number of each grid point among them: (n + 1, c).

    Compared in single precision, as files store them.
    """
    points = body.points.astype(np.float32).reshape(3, -1) + np.float32(0.0)
    found, names = np.unique(points, axis=1, return_inverse=True)
    return found.T.astype(float), names.reshape(body.radius.shape)


def _triangles(body: Body, names: Whole) -> Whole:
    """Two triangles a cell; in walls the diagonal is the same for columns up and down.

    So that two walls in one place cancel, triangle by triangle.
    """
    found = []
    for strip in body.strips:
        columns = [*range(strip.first, strip.last + 1)] or [strip.first, strip.last]
        grid = names[:, columns]
        here, beside = grid[:-1, :-1], grid[:-1, 1:]
        after, across = grid[1:, :-1], grid[1:, 1:]
        corners = (
            [(here, beside, across), (here, across, after)]
            if strip.rising
            else [(here, beside, after), (beside, across, after)]
        )
        found += [np.stack(each, axis=-1).reshape(-1, 3) for each in corners]
    return np.concatenate(found)


def _cancel_folds(triangles: Whole) -> Whole:
    """Without degenerate triangles, and without pairs that lie back to back."""
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    order = np.argsort(triangles, axis=1)
    sorted_ = np.take_along_axis(triangles, order, axis=1)
    even = (order[:, 1] - order[:, 0]) % 3 == 1
    _, first, which = np.unique(sorted_, axis=0, return_index=True, return_inverse=True)
    net = np.bincount(which.ravel(), weights=np.where(even, 1.0, -1.0))
    kept = np.flatnonzero(net)
    chosen, way = sorted_[first[kept]], net[kept] > 0
    return np.where(way[:, None], chosen, chosen[:, ::-1])
