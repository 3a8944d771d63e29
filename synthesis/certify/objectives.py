"""The value of an objective on the finished cam, enclosed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from synthesis.catalogue.followers.base import paths
from synthesis.catalogue.followers.sizing import prime_radius
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import Motion
from synthesis.certify.force_quantities import load_cuts, quantity_of
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.certify.quantities import (
    QUANTITIES,
    Quantity,
    Size,
    enclose_quantities,
    infinite_by_jump,
)
from synthesis.numerics.enclosure import Enclosure, ExtremumQuery
from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import FULL_TURN

RADIUS_ROUNDING: Final = 1e-15  # relative, of the prime radius computed from the size

# Gauss quadrature of the square of a derivative
WAVE_NODES: Final = 64  # on a piece with sinusoids; a polynomial needs as many as coefficients
BERNSTEIN_RHO: Final = 8.0  # sum of the semi-axes of the ellipse on which the integrand is bounded
QUADRATURE_ROUNDING: Final = 1e-13  # relative, of nodes, weights and sums


def measure_objective(quantity: str, motion: Motion, machine: Machine, size: Size) -> Enclosure:
    """The value of an objective on the finished cam, in core units.

    Args:
        quantity: a key of ``OBJECTIVES``.
        motion, machine, size: the finished cam.
    """
    size = tuple(float(value) for value in size)
    return OBJECTIVES[quantity](motion, machine, size)


def _prime_radius(motion: Motion, machine: Machine, size: Size) -> Enclosure:
    """The norm that stands for the prime radius, as its bounds do; the objective converts both."""
    value = machine.follower.norm_from_radius(prime_radius(machine.follower, size))
    rounding = RADIUS_ROUNDING
    return Enclosure(value, value * (1.0 - rounding), value * (1.0 + rounding), 0.0)


# -- peaks -----------------------------------------------------------------------------------


def _peak(name: str) -> Callable[[Motion, Machine, Size], Enclosure]:
    """The largest |s^(k)| over the turn."""

    def peak(motion: Motion, machine: Machine, size: Size) -> Enclosure:
        pieces = PiecewiseMotion(motion)
        return _peak_on(QUANTITIES[name], pieces, machine, size, _moving(pieces, dwells=True))

    return peak


def _pressure_slope(motion: Motion, machine: Machine, size: Size) -> Enclosure:
    """The largest |tan α| over rises and returns, of all traced curves."""
    pieces = PiecewiseMotion(motion)
    moving = _moving(pieces, dwells=False)
    if not moving:
        return Enclosure(0.0, 0.0, 0.0, 0.0)
    angle = QUANTITIES["pressure_angle"]
    each = [
        _largest(angle, pieces, machine, size, moving, path) for path in paths(machine.follower)
    ]
    found = max(each, key=lambda one: one.upper)
    value, lower, upper = (
        math.tan(end) if abs(end) < 0.5 * math.pi else math.copysign(math.inf, end)
        for end in (found.value, found.lower, found.upper)
    )
    return Enclosure(value, lower, upper, found.angle)


def _drive_force(motion: Motion, machine: Machine, size: Size) -> Enclosure:
    """The largest drive in the sense that presses the follower on its cam [N].

    Of a follower that is guided both ways, the largest |G|. Infinite if the spec gives no load.
    """
    load = machine.load
    if load is None:
        return Enclosure(math.inf, math.inf, math.inf, 0.0)
    pieces = PiecewiseMotion(motion, load_cuts(machine))
    force = quantity_of("drive_force", "", pieces, machine, size)
    pressing = (-math.inf, 0.0) if load.side > 0 else (0.0, math.inf)
    bounds = (0.0, 0.0) if load.pushed_both_ways else pressing
    return _peak_on(force, pieces, machine, size, _moving(pieces, dwells=True), bounds)


def _moving(motion: PiecewiseMotion, *, dwells: bool) -> list[int]:
    """Stretches of positive cam angle, with or without dwells."""
    return [s.index for s in motion.segments if s.angle > 0.0 and (dwells or s.kind != "dwell")]


def _peak_on(
    quantity: Quantity,
    motion: PiecewiseMotion,
    machine: Machine,
    size: Size,
    segments: Sequence[int],
    bounds: tuple[float, float] = (0.0, 0.0),
) -> Enclosure:
    """The peak of a quantity; infinite where a derivative of s below its own jumps."""
    jump = infinite_by_jump(quantity, motion, segments)
    if jump is not None:
        return Enclosure(math.inf, math.inf, math.inf, jump.angle)
    return _largest(quantity, motion, machine, size, segments, bounds=bounds)


def _largest(
    quantity: Quantity,
    motion: PiecewiseMotion,
    machine: Machine,
    size: Size,
    segments: Sequence[int],
    path: str = "",
    bounds: tuple[float, float] = (0.0, 0.0),
) -> Enclosure:
    """How far a quantity exceeds its bounds; for two bounds of 0 its largest absolute value."""
    question = ExtremumQuery(motion.pieces_of(segments), *bounds)
    (answer,) = enclose_quantities([(quantity, path)], motion, machine, size, [question])
    found = answer.enclosure
    if answer.side > 0:
        return found
    return Enclosure(-found.value, -found.upper, -found.lower, found.angle)


# -- root mean squares -----------------------------------------------------------------------


def _rms(name: str) -> Callable[[Motion, Machine, Size], Enclosure]:
    """√(1/2π ∫ (s^(k))² dθ) over the turn."""

    def rms(motion: Motion, machine: Machine, size: Size) -> Enclosure:
        pieces = PiecewiseMotion(motion)
        jump = infinite_by_jump(QUANTITIES[name], pieces, _moving(pieces, dwells=True))
        if jump is not None:
            return Enclosure(math.inf, math.inf, math.inf, jump.angle)
        return root_mean_square(pieces.jets, QUANTITIES[name].order)

    return rms


def root_mean_square(jets: Jets, order: int) -> Enclosure:
    """√(1/2π ∫ (f^(order))² dx) over the whole turn, by Gauss quadrature on every piece.

    The rule is exact for polynomial pieces. On pieces with sinusoids its error is at most
    (64/15) M ρ^(−2n) / (1 − ρ^(−2)), M the largest |f^(order)|² on the Bernstein ellipse of ρ
    (Trefethen, Approximation Theory and Approximation Practice, theorem 19.3).
    """
    curve = jets.curve
    nodes, weights = _gauss(WAVE_NODES if curve.waves.shape[1] else curve.poly.shape[1])
    half = 0.5 * np.diff(curve.breaks)
    middle = 0.5 * (curve.breaks[:-1] + curve.breaks[1:])
    x = middle[:, None] + half[:, None] * nodes
    piece = np.repeat(np.arange(curve.count), len(nodes))
    value, rounding = jets.at(piece, x.ravel(), order)
    squares, roundings = value * value, rounding * (2.0 * np.abs(value) + rounding)
    total = float(half @ (squares.reshape(x.shape) @ weights))
    error = float(half @ (roundings.reshape(x.shape) @ weights)) + QUADRATURE_ROUNDING * total
    error += _truncation(curve, order, half, len(nodes))
    low, high = max(total - error, 0.0), total + error
    ends = [math.sqrt(part / FULL_TURN) for part in (total, low, high)]
    return Enclosure(ends[0], ends[1], ends[2], 0.0)


@lru_cache(maxsize=64)
def _gauss(count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def _truncation(curve: Piecewise, order: int, half: Array, count: int) -> float:
    """Error bound of the Gauss rule with ``count`` nodes, over all pieces; 0 without sinusoids."""
    if not curve.waves.shape[1]:
        return 0.0
    # the ellipse lies in the disc of this radius about the piece's middle
    rho = BERNSTEIN_RHO
    reach = 0.5 * (rho + 1.0 / rho) * half
    away = np.abs(0.5 * (curve.breaks[:-1] + curve.breaks[1:]) - curve.origins) + reach
    # bound the polynomial there by absolute values, a sinusoid by cosh of the imaginary part
    poly = curve.poly
    for _ in range(order):
        poly = poly[:, 1:] * np.arange(1, poly.shape[1])
    largest = np.zeros(curve.count)
    for column in np.abs(poly).T[::-1]:
        largest = largest * away + column
    amplitude, frequency, _ = np.moveaxis(curve.waves, -1, 0)
    wave = np.abs(amplitude * frequency**order) * np.cosh(frequency * reach[:, None])
    largest = largest + np.sum(wave, axis=1)
    bound = half * largest**2 * (64.0 / 15.0) * rho ** (-2.0 * count) / (1.0 - rho**-2.0)
    return float(np.sum(bound))


OBJECTIVES: Final[dict[str, Callable[[Motion, Machine, Size], Enclosure]]] = {
    "prime_radius": _prime_radius,
    "velocity": _peak("velocity"),
    "acceleration": _peak("acceleration"),
    "jerk": _peak("jerk"),
    "rms_acceleration": _rms("acceleration"),
    "rms_jerk": _rms("jerk"),
    "pressure_slope": _pressure_slope,
    "drive_force": _drive_force,
}
