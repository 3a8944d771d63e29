"""How far points lie from a B-spline, by Newton's method on the foot of the perpendicular."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

DENSE = 40_000


def away(points: np.ndarray, spline: BSpline) -> np.ndarray:
    """(n,) distances of points (n, k)."""
    first, last = spline.t[spline.k], spline.t[-spline.k - 1]
    grid = np.linspace(first, last, DENSE)
    u = grid[cKDTree(spline(grid)).query(points)[1]]
    step = grid[1] - grid[0]
    for _ in range(6):
        off, slope, bend = spline(u) - points, spline(u, 1), spline(u, 2)
        down = np.sum(off * slope, axis=1)
        along = np.sum(slope**2, axis=1) + np.sum(off * bend, axis=1)
        u = np.clip(u - np.clip(down / along, -step, step), first, last)
    return np.linalg.norm(spline(u) - points, axis=1)
