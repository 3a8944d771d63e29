"""Cam angles at which a roller meshes with the cam: by position, and between the end faces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from synthesis.catalogue.motion import Motion
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.geometry.swept_roller import FollowerState, SweptRoller, dot
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

Span = tuple[float, float]
Inside = NDArray[np.bool_]
SAMPLES = 33  # on every piece of the motion, between which crossings are sought
PLACES = 5  # on the roller's axis, where a contact may lie between the end faces


def mesh_intervals(motion: Motion, seat: Seat, mesh: Span, period: float) -> tuple[Span, ...]:
    """Intervals of cam angle in one turn in which a roller meets the blank [rad].

    Args:
        mesh: range of q in mesh [rad or mm]. period: of q, after which a roller is back at its
            place; may be infinite.
    """
    joints = [0.0, *(segment.end for segment in motion.segments)]
    places = seat.start + motion.curve(np.linspace(0.0, FULL_TURN, SAMPLES * motion.curve.count))
    around = _periods(float(places.min()), float(places.max()), mesh, period)
    levels = [q - seat.start + shift for q in mesh for shift in around]
    marks = sorted({*joints, *(t for level in levels for t in _level_crossings(motion, level))})

    def within(middles: Array) -> Inside:
        q = seat.start + motion.derivatives(middles, 0)[0]
        rounds = np.array(around)[:, None]
        return np.asarray(((q > mesh[0] + rounds) & (q < mesh[1] + rounds)).any(axis=0))

    return _merge_intervals(marks, within)


def intervals_between_faces(
    swept: SweptRoller, motion: Motion, seat: Seat, side: int, span: Span, faces: Span
) -> tuple[Span, ...]:
    """The parts of an interval in which some contact of a wall lies between the end faces.

    Args:
        faces: their positions along the cam's axis from its centre [mm].
    """
    if all(math.isinf(face) for face in faces):
        return (span,)
    rho = np.linspace(swept.roller.inner, swept.roller.outer, PLACES)

    def beyond(theta: Array) -> Array:
        """Distance of the nearest contact beyond the end faces, negative between them, (n,)."""
        q, q1, q2 = motion.derivatives(theta, 2)
        point, _ = swept.contact_points(FollowerState(seat.start + q, q1, q2), rho, side)
        along = dot(swept.axis.reshape(3, 1, 1), point - swept.centre.reshape(3, 1, 1))
        return np.asarray(np.maximum(faces[0] - along, along - faces[1]).min(axis=1))

    inner = [float(b) for b in motion.curve.breaks if span[0] < b < span[1]]
    marks = [span[0], *inner, span[1]]
    samples = np.unique(np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(marks)]))
    crossings = _crossings(lambda t: float(beyond(np.array([t]))[0]), samples, beyond(samples))
    return _merge_intervals(
        sorted({span[0], *crossings, span[1]}), lambda t: np.asarray(beyond(t) < 0.0)
    )


def _merge_intervals(marks: Sequence[float], within: Callable[[Array], Inside]) -> tuple[Span, ...]:
    """Intervals between marks whose middles are within, merged where they meet."""
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


def _periods(low: float, high: float, mesh: Span, period: float) -> list[float]:
    """Multiples of the period by which the mesh range may be met between two positions."""
    if math.isinf(period):
        return [0.0]
    first, last = math.floor((low - mesh[1]) / period), math.ceil((high - mesh[0]) / period)
    return [period * k for k in range(first, last + 1)]


def _level_crossings(motion: Motion, level: float) -> Iterable[float]:
    """Cam angles where the motion crosses a level; points of tangency may be missed."""
    breaks = motion.curve.breaks
    samples = np.unique(np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(breaks)]))
    return _crossings(
        lambda t: float(motion.curve(t)) - level, samples, motion.curve(samples) - level
    )


def _crossings(of: Callable[[float], float], samples: Array, values: Array) -> Iterable[float]:
    """Roots between samples of opposite sign."""
    high = values > 0.0
    changes = np.flatnonzero(high[1:] != high[:-1])
    return [brentq(of, samples[i], samples[i + 1], xtol=1e-14) for i in changes]
