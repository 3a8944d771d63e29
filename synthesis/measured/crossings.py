"""Whether a closed polygon crosses itself."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

BLOCK: Final = 48  # sides that share a bounding box


def first_crossing(ring: Array) -> tuple[float, float] | None:
    """A point where two sides of a closed polygon (n, 2) cross; None where none do.

    Blocks of sides are compared by bounding box first, so that a long ring costs little.
    """
    start, end = ring, np.roll(ring, -1, axis=0)
    firsts = np.arange(0, len(ring), BLOCK)
    low = np.minimum.reduceat(np.minimum(start, end), firsts)
    high = np.maximum.reduceat(np.maximum(start, end), firsts)
    meet = np.all((low[:, None] <= high) & (low <= high[:, None]), axis=2)
    for a, b in np.argwhere(np.triu(meet)):
        i, j = (np.arange(k * BLOCK, min((k + 1) * BLOCK, len(ring))) for k in (a, b))
        found = _crossing(start, end, i, j)
        if found is not None:
            return found
    return None


def _crossing(
    start: Array, end: Array, i: NDArray[np.intp], j: NDArray[np.intp]
) -> tuple[float, float] | None:
    """Of sides i against sides j, neighbours left out."""
    n = len(start)
    p, r = start[i][:, None], (end - start)[i][:, None]
    q, s = start[j][None], (end - start)[j][None]
    across = r[..., 0] * s[..., 1] - r[..., 1] * s[..., 0]
    to = q - p
    apart = (j[None] - i[:, None]) % n
    proper = (apart > 1) & (apart < n - 1) & (across != 0.0)
    safe = np.where(proper, across, 1.0)
    t = (to[..., 0] * s[..., 1] - to[..., 1] * s[..., 0]) / safe
    w = (to[..., 0] * r[..., 1] - to[..., 1] * r[..., 0]) / safe
    hit = proper & (t >= 0.0) & (t <= 1.0) & (w >= 0.0) & (w <= 1.0)
    if not hit.any():
        return None
    a, b = np.unravel_index(int(np.argmax(hit)), hit.shape)
    x, y = p[a, 0] + t[a, b] * r[a, 0]
    return float(x), float(y)
