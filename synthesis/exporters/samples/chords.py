"""Cam angles whose chords stay within a tolerance of the true curve."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.exporters.options import MAX_POINTS
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

COARSEST = 10.0 * DEGREE  # no two points further apart than this
FINEST = 0.5 * DEGREE  # spacing at which the curvature is looked at
PROBES = np.arange(1, 8) / 8.0  # where a chord is measured
MARGIN = 0.93  # measured at the probes, a lobe's top is missed by at most (1/8)² · 4 of its height


def chord_angles(cam: Cam, ends: Array, tolerance: float) -> Array:
    """Angles from the first of ``ends`` to the last, all of ``ends`` among them.

    On each span between two ends the spacing follows the curvature, so that all chords depart
    about alike; then every chord is measured, and spans that exceed are sampled more densely.

    Args:
        cam: the cam and its curve.
        ends: (m,) increasing angles [rad], between which the curve is smooth.
        tolerance: largest distance of the curve from its chord [mm].
    """
    density = [_density(cam, a, b, tolerance) for a, b in pairwise(ends.tolist())]
    most = np.array([max(1.0, np.ceil(total[-1])) for _, total in density])
    while True:
        if not most.sum() <= MAX_POINTS:
            raise InputError(
                "/tolerance_um",
                tolerance * 1e3,
                f"This chord tolerance would need more than {MAX_POINTS} points.",
                "Allow a larger one.",
            )
        spans = [
            np.interp(np.linspace(0.0, total[-1], int(n) + 1), total, angle)
            for (angle, total), n in zip(density, most, strict=True)
        ]
        excess = np.array([_departure(cam, span) for span in spans]) / (MARGIN * tolerance)
        if np.all(excess <= 1.0):
            return np.concatenate([span[:-1] for span in spans] + [ends[-1:]])
        most = np.where(excess > 1.0, np.ceil(most * np.clip(np.sqrt(excess), 1.02, 4.0)), most)


def _density(cam: Cam, start: float, end: float, tolerance: float) -> tuple[Array, Array]:
    """Angles on a span and the number of chords needed from its start up to them, (k,) each.

    A chord over dθ departs by κ (v dθ)²/8 from a curve of curvature κ run through at v = ds/dθ.
    """
    angle = np.linspace(start, end, max(8, int(np.ceil((end - start) / FINEST))) + 1)
    middle = 0.5 * (angle[1:] + angle[:-1])
    at = cam.at(middle)
    speed_squared = cam.flank.trace.curvature_terms(at.s, cam.size)[1]
    # along a curve at the gap g, v shrinks by 1 − κ g, and κ grows by its inverse
    bend = np.abs(at.curvature * (1.0 - at.curvature * cam.gap))
    needed = np.sqrt(bend * speed_squared / (8.0 * MARGIN * tolerance))
    needed = np.maximum(needed, max(0.1 * float(np.mean(needed)), 1.0 / COARSEST))
    return angle, np.concatenate([[0.0], np.cumsum(needed * np.diff(angle))])


def _departure(cam: Cam, span: Array) -> float:
    """Largest distance of the curve from the chords of one span [mm]."""
    x, y = cam.place(cam.at(span, _last(span)))
    probe = span[:-1, None] + PROBES * np.diff(span)[:, None]
    px, py = (value.reshape(probe.shape) for value in cam.place(cam.at(probe.ravel())))
    dx, dy = np.diff(x)[:, None], np.diff(y)[:, None]
    rx, ry = px - x[:-1, None], py - y[:-1, None]
    length = np.maximum(dx * dx + dy * dy, np.finfo(float).tiny)
    along = np.clip((rx * dx + ry * dy) / length, 0.0, 1.0)
    return float(np.max(np.hypot(rx - along * dx, ry - along * dy)))


def _last(span: Array) -> NDArray[np.bool_]:
    """True at the last angle alone: a span ends with the limit from its own side."""
    mask = np.zeros(len(span), dtype=bool)
    mask[-1] = True
    return mask
