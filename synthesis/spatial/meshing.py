"""When a roller meets the cam: within its mesh, and between the end faces of the blank."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from synthesis.geometry.swept_roller import Place, SweptRoller, dot
from synthesis.motion import Motion
from synthesis.numerics.piecewise import Array
from synthesis.spatial.machine import Seat
from synthesis.units import FULL_TURN

Span = tuple[float, float]
Inside = NDArray[np.bool_]
TRIED = 33  # places on every piece of the motion between which it is followed
ALONG = 5  # places on the roller's axis where a contact may be between the end faces


def in_mesh(motion: Motion, seat: Seat, mesh: Span, period: float) -> tuple[Span, ...]:
    """Cam angles within one turn between which a roller meets the blank [rad].

    Args:
        mesh: q between which it does [rad or mm]. period: what brings it back to where it was;
            infinite where nothing does.
    """
    joints = [0.0, *(stretch.end for stretch in motion.stretches)]
    places = seat.start + motion.curve(np.linspace(0.0, FULL_TURN, TRIED * motion.curve.count))
    around = _rounds(float(places.min()), float(places.max()), mesh, period)
    levels = [q - seat.start + shift for q in mesh for shift in around]
    marks = sorted({*joints, *(t for level in levels for t in _reaches(motion, level))})

    def within(middles: Array) -> Inside:
        q = seat.start + motion.derivatives(middles, 0)[0]
        rounds = np.array(around)[:, None]
        return np.asarray(((q > mesh[0] + rounds) & (q < mesh[1] + rounds)).any(axis=0))

    return _joined(marks, within)


def between_faces(
    swept: SweptRoller, motion: Motion, seat: Seat, side: int, span: Span, faces: Span
) -> tuple[Span, ...]:
    """The parts of a span where some contact of a wall lies between the end faces.

    Args:
        faces: their places along the cam's axis from its centre [mm].
    """
    if all(math.isinf(face) for face in faces):
        return (span,)
    rho = np.linspace(swept.roller.inner, swept.roller.outer, ALONG)

    def beyond(theta: Array) -> Array:
        """How far the nearest contact is outside [mm], (n,)."""
        q, q1, q2 = motion.derivatives(theta, 2)
        point, _ = swept.touched(Place(seat.start + q, q1, q2), rho, side)
        along = dot(swept.axis.reshape(3, 1, 1), point - swept.centre.reshape(3, 1, 1))
        return np.asarray(np.maximum(faces[0] - along, along - faces[1]).min(axis=1))

    inner = [float(b) for b in motion.curve.breaks if span[0] < b < span[1]]
    marks = [span[0], *inner, span[1]]
    tried = np.unique(np.concatenate([np.linspace(a, b, TRIED) for a, b in pairwise(marks)]))
    crossings = _crossings(lambda t: float(beyond(np.array([t]))[0]), tried, beyond(tried))
    return _joined(sorted({span[0], *crossings, span[1]}), lambda t: np.asarray(beyond(t) < 0.0))


def _joined(marks: Sequence[float], within: Callable[[Array], Inside]) -> tuple[Span, ...]:
    """Neighbouring intervals between marks whose middles are within, as one where they meet."""
    inside = within(np.array([0.5 * (a + b) for a, b in pairwise(marks)]))
    spans: list[Span] = []
    for (a, b), counts in zip(pairwise(marks), inside, strict=True):
        if not counts:
            continue
        if spans and spans[-1][1] == a:
            spans[-1] = (spans[-1][0], b)
        else:
            spans.append((a, b))
    return tuple(spans)


def _rounds(low: float, high: float, mesh: Span, period: float) -> list[float]:
    """Multiples of the period by which the mesh may be met between two places q."""
    if math.isinf(period):
        return [0.0]
    first, last = math.floor((low - mesh[1]) / period), math.ceil((high - mesh[0]) / period)
    return [period * k for k in range(first, last + 1)]


def _reaches(motion: Motion, level: float) -> Iterable[float]:
    """Cam angles where the motion passes a level; one that it only touches may be left out."""
    breaks = motion.curve.breaks
    tried = np.unique(np.concatenate([np.linspace(a, b, TRIED) for a, b in pairwise(breaks)]))
    return _crossings(lambda t: float(motion.curve(t)) - level, tried, motion.curve(tried) - level)


def _crossings(of: Callable[[float], float], tried: Array, values: Array) -> Iterable[float]:
    """Where a function changes its sign between two of the places tried."""
    high = values > 0.0
    changes = np.flatnonzero(high[1:] != high[:-1])
    return [brentq(of, tried[i], tried[i + 1], xtol=1e-14) for i in changes]
