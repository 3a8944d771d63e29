"""Planar faces of a mesh: coplanar triangles across the cam's axis merged, the others single."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from synthesis.machines.spatial.triangulation import Mesh, Whole
from synthesis.numerics.piecewise import Array

Loop = list[int]


@dataclass(frozen=True, eq=False)
class Facet:
    """A flat face.

    Attributes:
        normal: (3,) outward unit normal. loops: points of the mesh, the outer boundary first,
            counter-clockwise seen from outside, then holes, clockwise.
    """

    normal: Array
    loops: list[Loop]


def merge_planar_faces(mesh: Mesh) -> list[Facet]:
    """All faces of a mesh without degenerate triangles.

    Only planes perpendicular to the axis are merged, where heights are equal to the bit. A part
    whose boundary touches itself in a point stays in triangles.
    """
    normals = _area_normals(mesh)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    whole: list[Facet] = []
    single = np.ones(len(mesh.triangles), dtype=bool)
    for part in _coplanar_parts(mesh, normals):
        loops = _boundary(mesh, mesh.triangles[part], float(normals[part[0], 2]))
        if loops:
            whole.append(Facet(normals[part[0]], loops))
            single[part] = False
    rest = zip(normals[single], mesh.triangles[single].tolist(), strict=True)
    return whole + [Facet(normal, [corners]) for normal, corners in rest]


def thinnest(mesh: Mesh) -> float:
    """Least height of any triangle [mm]."""
    corners = mesh.points[mesh.triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return float(np.min(np.linalg.norm(_area_normals(mesh), axis=1) / np.max(sides, axis=1)))


def _area_normals(mesh: Mesh) -> Array:
    """(k, 3) outward normals, of twice the triangles' areas."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    return np.asarray(np.cross(b - a, c - a))


def _coplanar_parts(mesh: Mesh, normals: Array) -> list[Whole]:
    """Sets of triangles at one height with one orientation, connected by edges."""
    heights = mesh.points[mesh.triangles, 2]
    level = np.ptp(heights, axis=1) == 0.0
    flat = np.flatnonzero(level)
    if len(flat) < 2:
        return []
    corners, up = mesh.triangles[flat], normals[flat, 2] > 0.0
    ends = np.concatenate([corners, np.roll(corners, -1, axis=1)]).reshape(2, -1)
    _, edge = np.unique(np.sort(ends, axis=0), axis=1, return_inverse=True)
    owner = np.repeat(np.arange(len(flat)), 3)
    order = np.argsort(edge, kind="stable")
    pair = np.flatnonzero(np.diff(edge[order]) == 0)
    one, other = owner[order[pair]], owner[order[pair + 1]]
    same = up[one] == up[other]
    links = coo_array((np.ones(same.sum()), (one[same], other[same])), shape=(len(flat),) * 2)
    count, part = connected_components(links, directed=False)
    parts = [flat[part == i] for i in range(count)]
    return [each for each in parts if len(each) > 1]


def _boundary(mesh: Mesh, triangles: Whole, up: float) -> list[Loop]:
    """Boundary loops of coplanar triangles, the outer one first; empty: one touches itself."""
    ends = [(a, b) for t in triangles.tolist() for a, b in zip(t, [*t[1:], t[0]], strict=True)]
    inside = set(ends)
    after = {a: b for a, b in ends if (b, a) not in inside}
    if len(after) < sum((b, a) not in inside for a, b in ends):
        return []
    loops = []
    while after:
        start, b = after.popitem()
        loop = [start]
        while b != start:
            loop.append(b)
            b = after.pop(b)
        loops.append(loop)
    areas = [up * _area(mesh.points[loop, :2]) for loop in loops]
    outer = int(np.argmax(areas))
    return [loops[outer], *loops[:outer], *loops[outer + 1 :]]


def _area(points: Array) -> float:
    x, y = points.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
