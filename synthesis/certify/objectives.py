"""The value of an objective on the finished cam, enclosed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from synthesis.catalogue.followers.base import paths, prime_radius
from synthesis.catalogue.limits.base import Machine, segment_indices
from synthesis.catalogue.motion import Motion
from synthesis.certify.quantities import (
    BOUNDS,
    QUANTITIES,
    MeasuredCam,
    Quantity,
    Size,
    infinite_by_jump,
    quantity_of,
)
from synthesis.numerics.enclosure import Enclosure
from synthesis.numerics.piecewise import Piecewise, gauss_points
from synthesis.numerics.taylor import Jets
from synthesis.units import FULL_TURN

Objective = Callable[[MeasuredCam], Enclosure]

RADIUS_ROUNDING: Final = 1e-15  # relative, of the prime radius computed from the size

# Gauss quadrature of the square of a derivative
WAVE_NODES: Final = 64  # on a piece with sinusoids; a polynomial needs as many as coefficients
BERNSTEIN_RHO: Final = 8.0  # sum of the semi-axes of the ellipse on which the integrand is bounded
QUADRATURE_ROUNDING: Final = 1e-13  # relative, of nodes, weights and sums


def measure_objective(quantity: str, motion: Motion, machine: Machine, size: Size) -> Enclosure:
    """The value of an objective, a key of ``OBJECTIVES``, on the finished cam, in core units."""
    return OBJECTIVES[quantity](MeasuredCam.of(motion, machine, size))


def _prime_radius(cam: MeasuredCam) -> Enclosure:
    """The norm that stands for the prime radius, as its bounds do; the objective converts both."""
    follower = cam.machine.follower
    value = follower.norm_from_radius(prime_radius(follower, cam.size))
    low, high = value * (1.0 - RADIUS_ROUNDING), value * (1.0 + RADIUS_ROUNDING)
    return Enclosure(value, low, high, 0.0)


def _peak(cam: MeasuredCam, name: str) -> Enclosure:
    """The largest |s^(k)| over the turn."""
    return _peak_on(QUANTITIES[name], cam, segment_indices(cam.motion.segments))


def _pressure_slope(cam: MeasuredCam) -> Enclosure:
    """The largest |tan α| over rises and returns, of all traced curves."""
    moving = [s.index for s in cam.motion.segments if s.kind != "dwell"]
    if not moving:
        return Enclosure(0.0, 0.0, 0.0, 0.0)
    angle = QUANTITIES["pressure_angle"]
    each = [_peak_on(angle, cam, moving, path) for path in paths(cam.machine.follower)]
    found = max(each, key=lambda one: one.upper)
    value, lower, upper = (
        math.tan(end) if abs(end) < 0.5 * math.pi else math.copysign(math.inf, end)
        for end in (found.value, found.lower, found.upper)
    )
    return Enclosure(value, lower, upper, found.angle)


def _drive_force(cam: MeasuredCam) -> Enclosure:
    """The largest drive in the sense that presses the follower on its cam [N].

    Of a follower that is guided both ways, the largest |G|. Infinite if the spec gives no load.
    """
    load = cam.machine.load
    if load is None:
        return Enclosure(math.inf, math.inf, math.inf, 0.0)
    bounds = (0.0, 0.0) if load.pushed_both_ways else BOUNDS[load.side]
    everywhere = segment_indices(cam.motion.segments)
    return _peak_on(quantity_of("drive_force", "", cam), cam, everywhere, bounds=bounds)


def _peak_on(
    quantity: Quantity,
    cam: MeasuredCam,
    segments: Sequence[int],
    path: str = "",
    bounds: tuple[float, float] = (0.0, 0.0),
) -> Enclosure:
    """How far a quantity exceeds its bounds; for two bounds of 0 its largest absolute value.

    Infinite where a derivative of s below its own jumps.
    """
    jump = infinite_by_jump(quantity, cam.motion, segments)
    if jump is not None:
        return Enclosure(math.inf, math.inf, math.inf, jump.angle)
    answer = cam.extreme((quantity, path), segments, bounds)
    found = answer.enclosure
    if answer.side > 0:
        return found
    return Enclosure(-found.value, -found.upper, -found.lower, found.angle)


def _rms(cam: MeasuredCam, name: str) -> Enclosure:
    """√(1/2π ∫ (s^(k))² dθ) over the turn."""
    quantity = QUANTITIES[name]
    jump = infinite_by_jump(quantity, cam.motion, segment_indices(cam.motion.segments))
    if jump is not None:
        return Enclosure(math.inf, math.inf, math.inf, jump.angle)
    return root_mean_square(cam.motion.jets, quantity.order)


def root_mean_square(jets: Jets, order: int) -> Enclosure:
    """√(1/2π ∫ (f^(order))² dx) over the whole turn, by Gauss quadrature on every piece.

    The rule is exact for polynomial pieces. On pieces with sinusoids its error is at most
    (64/15) M ρ^(−2n) / (1 − ρ^(−2)), M the largest |f^(order)|² on the Bernstein ellipse of ρ
    (Trefethen, Approximation Theory and Approximation Practice, theorem 19.3).
    """
    curve = jets.curve
    count = WAVE_NODES if curve.waves.shape[1] else curve.poly.shape[1]
    x, weights = gauss_points(curve.breaks, count)
    piece = np.repeat(np.arange(curve.count), count)
    value, rounding = (row[order] for row in jets.derivatives(piece, x.ravel()))
    total = float(weights.ravel() @ (value * value))
    error = float(weights.ravel() @ (rounding * (2.0 * np.abs(value) + rounding)))
    error += QUADRATURE_ROUNDING * total + _truncation(curve, order, count)
    low, high = max(total - error, 0.0), total + error
    value, lower, upper = (math.sqrt(part / FULL_TURN) for part in (total, low, high))
    return Enclosure(value, lower, upper, 0.0)


def _truncation(curve: Piecewise, order: int, count: int) -> float:
    """Error bound of the Gauss rule with ``count`` nodes, over all pieces; 0 without sinusoids."""
    if not curve.waves.shape[1]:
        return 0.0
    # the ellipse lies in the disc of this radius about the piece's middle: bound the polynomial
    # there by absolute values, a sinusoid by cosh of the imaginary part
    rho, pieces, half = BERNSTEIN_RHO, np.arange(curve.count), 0.5 * np.diff(curve.breaks)
    reach = 0.5 * (rho + 1.0 / rho) * half
    away = np.abs(0.5 * (curve.breaks[:-1] + curve.breaks[1:]) - curve.origins) + reach
    poly = replace(curve, waves=curve.waves[:, :0])
    amplitude, frequency, _ = np.moveaxis(curve.waves, -1, 0)
    wave = np.abs(amplitude * frequency**order) * np.cosh(frequency * reach[:, None])
    largest = poly.bound_derivative(pieces, away, order) + np.sum(wave, axis=1)
    bound = half * largest**2 * (64.0 / 15.0) * rho ** (-2.0 * count) / (1.0 - rho**-2.0)
    return float(np.sum(bound))


OBJECTIVES: Final[dict[str, Objective]] = {
    "prime_radius": _prime_radius,
    **{name: partial(_peak, name=name) for name in ("velocity", "acceleration", "jerk")},
    "rms_acceleration": partial(_rms, name="acceleration"),
    "rms_jerk": partial(_rms, name="jerk"),
    "pressure_slope": _pressure_slope,
    "drive_force": _drive_force,
}
