"""All shapers with a rocking guide that meet the requirements, and what is minimised over them.

Where only the guide turns the ram back, the strokes are closed forms of s = sin β = r/a:

    quick-return ratio  Q = (π + 2β)/(π − 2β)          stroke  S = 2 L s

The coupler's angle γ obeys c sin γ = H − L sin ψ, linear in sin ψ, which runs from cos β to 1. So
|sin γ| ≤ k everywhere is |H − L| ≤ c k and |H − L cos β| ≤ c k; and guide and coupler are in line
nowhere if besides |H − L cos β| < c cos β. Taken in the order s, L, a, c, H, the range of each
depends on the ones before alone: the unit box maps onto the set of feasible shapers, and every
point of the box is a feasible shaper. The formulas serve numbers and affine models alike.
``ShaperObjective`` is the largest of a few functions of such a shaper.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from synthesis.catalogue.fields import ends
from synthesis.machines.linkages.shaper.mechanism import Narrowing, Shaper, Value
from synthesis.machines.linkages.shaper.spec import LENGTHS, ShaperSpec
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

Span = tuple[float, float]
CLEARANCE: Final = 1e-9  # of a sine, from where links are in line, or upright, or do not move
ROUNDING: Final = 1e-12  # relative: rounding of a number that is given by two fields
# Crank angles at which points are compared; the finished linkage is measured by enclosures.
CRANK_ANGLES: Final = FULL_TURN * np.arange(240) / 240


def swing_sine(ratio: float) -> float:
    """s = sin β for a quick-return ratio."""
    return math.sin(0.5 * math.pi * (ratio - 1.0) / (ratio + 1.0))


def quick_return_ratio_of(sine: float) -> float:
    """The quick-return ratio for s = sin β."""
    beta = math.asin(sine)
    return (math.pi + 2.0 * beta) / (math.pi - 2.0 * beta)


@dataclass(frozen=True)
class ShaperBatch:
    """Shapers as arrays (n,) or affine models; lengths in mm."""

    s: Value  # sin β
    cosine: Value  # cos β
    guide: Value
    pivot_distance: Value
    coupler: Value
    middle_sine: Value  # sin γ at the middle of the swing, (H − L)/c
    deficit: Value  # length that the coupler lacks to reach everywhere; positive: infeasible
    narrow: Narrowing = lambda sine: sine  # narrows sin γ to its range, where it is a model

    @property
    def ram_line(self) -> Value:
        """H [mm]."""
        return self.guide + self.coupler * self.middle_sine

    @property
    def end_sine(self) -> Value:
        """sin γ at the ends of the swing."""
        return self.middle_sine + self.guide * (1.0 - self.cosine) / self.coupler


@dataclass(frozen=True)
class DesignSpace:
    """The feasible shapers of a spec; lengths in mm."""

    sines: dict[str, Span]  # range of s = sin β that each field allows, by field
    lengths: dict[str, Span]  # in the order of LENGTHS
    stroke: Span
    largest_sine: float  # k, the largest |sin γ|

    @classmethod
    def of(cls, spec: ShaperSpec) -> DesignSpace:
        """Of a spec with a stroke and a quick-return ratio."""
        lengths, stroke = spec.length_ranges(), ends(spec.stroke_mm)
        (r, R), (guide, GUIDE), _, (a, A), _ = lengths.values()
        ratio = ends(spec.quick_return_ratio)
        sines = {
            "quick_return_ratio": (swing_sine(ratio[0]), swing_sine(ratio[1])),
            "crank_mm": (r / A, R / a),
            "stroke_mm": (stroke[0] / (2.0 * GUIDE), stroke[1] / (2.0 * guide)),
        }
        least = spec.least_transmission_angle_deg
        largest_sine = 1.0 - CLEARANCE if least is None else math.cos(least * DEGREE)
        return cls(sines, lengths, stroke, largest_sine)

    def sine_range(self, *without: str) -> Span:
        """Range of s with some fields left aside; empty where the lower end is above the upper."""
        spans = [span for name, span in self.sines.items() if name not in without]
        low = max(CLEARANCE, *(span[0] for span in spans))
        high = min(1.0 - CLEARANCE, *(span[1] for span in spans))
        if high < low <= high * (1.0 + ROUNDING):
            low = high
        return low, high

    def at(self, u: Sequence[Value] | Array) -> ShaperBatch:
        """The shapers at points of the unit box: five coordinates, (n,) or models."""
        k, stroke = self.largest_sine, self.stroke
        (r, R), (guide, GUIDE), (c, C), (a, A), (H0, H1) = self.lengths.values()
        s = _between(u[0], *self.sine_range())
        cosine, zero = np.sqrt(1.0 - s * s), 0.0 * s  # zero: numbers as arrays or models
        # The guide from the stroke, S = 2 L s; the pivot distance from the crank, r = a s.
        L = _between(u[1], np.maximum(guide + zero, 0.5 * stroke[0] / s),
                     np.minimum(GUIDE + zero, 0.5 * stroke[1] / s))  # fmt: skip
        distance = _between(u[2], np.maximum(a + zero, r / s), np.minimum(A + zero, R / s))
        # The coupler reaches a ram's line in its range from both ends of the guide's height, L and
        # L cos β: |sin γ| is at most k at the middle of the swing, ``near`` at its ends.
        near = np.minimum(k + zero, cosine * (1.0 - CLEARANCE))
        low = L * cosine
        least = np.maximum((L - low) / (k + near), np.maximum((L - H1) / k, (H0 - L) / k))
        least = np.maximum(least, np.maximum((low - H1) / near, (H0 - low) / near))
        coupler = _between(u[3], np.maximum(c + zero, least), C + zero)
        # The ram's line by sin γ at the middle; at the ends it is larger by ``rise``.
        rise = (L - low) / coupler
        middle_sine = _between(
            u[4],
            np.maximum((H0 - L) / coupler, np.maximum(-k + zero, -near - rise)),
            np.minimum((H1 - L) / coupler, np.minimum(k + zero, near - rise)),
        )
        return ShaperBatch(s, cosine, L, distance, coupler, middle_sine, least - C)

    def lengths_at(self, u: Array) -> dict[str, float] | None:
        """The lengths [mm] at one point (5,) of the unit box; None: no coupler is long enough."""
        one = self.at(u[:, None])
        if float(one.deficit[0]) > ROUNDING * float(one.coupler[0]):
            return None
        crank = one.s * one.pivot_distance
        lengths = (crank, one.guide, one.coupler, one.pivot_distance, one.ram_line)
        return {
            name: float(np.clip(each[0], *self.lengths[name]))
            for name, each in zip(LENGTHS, lengths, strict=True)
        }


def _between(u: Value, low: Value, high: Value) -> Value:
    return low + u * (high - low)


@dataclass(frozen=True)
class ShaperObjective:
    """An objective: minimise the largest of a few functions, ``parts``."""

    name: str  # of its value on the wire, with its unit
    parts: Callable[[ShaperBatch, Value], list[Value]]  # of shapers and a crank angle [rad]
    # From their largest value and the crank speed ω [rad/s] to the value on the wire.
    to_wire: Callable[[float, float], float] = lambda value, _: value
    angles: bool = False  # whether the parts depend on the crank angle
    # Lower bounds of the parts, with the ram's line (range, mm) already minimised over: better ones
    # than the parts themselves have.
    floor: Callable[[ShaperBatch, Span], list[Value]] | None = None

    def lower_bounds(self, one: ShaperBatch, phi: Sequence[float], ram_line: Span) -> list[Value]:
        """Lower bounds of the objective, from its functions at some crank angles."""
        if self.floor is not None:
            return self.floor(one, ram_line)
        return [part for angle in phi for part in self.parts(one, angle)]

    def over_turn(self, one: ShaperBatch) -> Array:
        """The functions at points, (functions, n, crank angles)."""
        columns = {name: each[:, None] for name, each in vars(one).items() if name != "narrow"}
        phi = CRANK_ANGLES if self.angles else CRANK_ANGLES[:1]
        return np.stack(self.parts(ShaperBatch(**columns), phi))

    def values(self, one: ShaperBatch) -> Array:
        """The objective at points, (n,)."""
        return np.asarray(np.max(self.over_turn(one), axis=(0, 2)))


def _least_coupler_sines(one: ShaperBatch, ram_line: Span) -> list[Value]:
    """|sin γ| with the ram's line midway between the guide's extreme heights, or as near."""
    low, (lowest, highest) = one.guide * one.cosine, ram_line
    rest = [0.5 * (one.guide - low), one.guide - highest, lowest - low]
    return [each / one.coupler for each in rest]


def _second_derivative(one: ShaperBatch, phi: Value) -> list[Value]:
    """|x''| at a crank angle, of the similar shaper with coupler and pivot distance 1."""
    guide = one.guide / one.coupler
    similar = Shaper(one.s, guide, 1.0, 1.0, guide + one.middle_sine)
    bend = one.coupler * similar.motion(phi, one.narrow).ram[2]
    return [bend, -bend]


OBJECTIVES: Final = {
    # The crank is shorter than the pivot distance.
    "longest_link": ShaperObjective(
        "longest_link_mm", lambda one, _: [one.guide, one.coupler, one.pivot_distance]
    ),
    # |sin γ| at the middle and at the ends of the swing.
    "transmission_angle": ShaperObjective(
        "least_transmission_angle_deg",
        lambda one, _: [one.middle_sine, -one.middle_sine, one.end_sine, -one.end_sine],
        lambda value, _: 90.0 - math.asin(min(max(value, 0.0), 1.0)) / DEGREE,
        floor=_least_coupler_sines,
    ),
    "ram_acceleration": ShaperObjective(
        "ram_acceleration_mm_per_s2", _second_derivative, lambda value, omega: value * omega**2,
        angles=True,
    ),
}  # fmt: skip
SHORTEST_COUPLER: Final = ShaperObjective("coupler_mm", lambda one, _: [one.coupler])
