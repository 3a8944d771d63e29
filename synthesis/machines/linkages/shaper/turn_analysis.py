"""A shaper over one turn: assembly, dead centres in closed form, extremes by enclosures."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from synthesis.errors import InputError
from synthesis.machines.linkages.shaper.drive import Drive
from synthesis.machines.linkages.shaper.mechanism import SIGN, Motion, Shaper
from synthesis.numerics.enclosure import Extremum, ExtremumQuery, enclose
from synthesis.numerics.taylor import Array, Taylor
from synthesis.units import DEGREE, FULL_TURN

Value = Any
BOXES: Final = 64  # crank-angle intervals of the first level of an enclosure
SAME: Final = 1e-9  # rad: nearer dead centres are one
SHORTEST: Final = 1e-6  # of the longest length: shorter ones drown in rounding
CHANGE_POINT: Final = 1e-9  # of the pivot distance: a crank this near to it has a change point


@dataclass(frozen=True)
class DeadCentre:
    """A position where the ram's velocity is zero.

    Attributes:
        turned: since the start of the turn [rad]. phi: crank angle [rad]. ram: x [mm].
        cause: guide_turns_back, or in_line (guide and coupler).
    """

    turned: float
    phi: float
    ram: float
    cause: str


@dataclass(frozen=True)
class Peak:
    """One extreme: a value that is reached, where, and the width of its enclosure, if proven."""

    value: float
    turned: float
    width: float | None


@dataclass(frozen=True)
class Quantity:
    """A quantity with extremes over the turn.

    Attributes:
        name, unit: on the wire. per_unit: core units in one of the wire's.
        of: from motion, drive and angle turned to the value.
    """

    name: str
    unit: str
    of: Callable[[Motion, Drive, Value], Value]
    per_unit: float = 1.0


QUANTITIES: Final = (
    Quantity("ram_velocity", "mm/s", lambda m, d, t: d.first(m.ram[1], t)),
    Quantity("ram_acceleration", "mm/s²", lambda m, d, t: d.second(m.ram[1], m.ram[2], t)),
    Quantity("guide_velocity", "deg/s", lambda m, d, t: d.first(m.guide_turn[0], t), DEGREE),
    Quantity("guide_acceleration", "deg/s²", lambda m, d, t: d.second(*m.guide_turn, t), DEGREE),
    Quantity("coupler_velocity", "deg/s", lambda m, d, t: d.first(m.coupler_turn[0], t), DEGREE),
    Quantity(
        "coupler_acceleration", "deg/s²", lambda m, d, t: d.second(*m.coupler_turn, t), DEGREE
    ),
    Quantity("sliding_velocity", "mm/s", lambda m, d, t: d.first(m.slide[1], t)),
)  # fmt: skip


def check_assembly(shaper: Shaper) -> None:
    """Refuse a shaper that cannot make a full turn.

    Raises:
        InputError: the crank is as long as the pivot distance (a change point), the coupler does
            not reach the ram's line, or lengths differ by more than a factor of a million.
    """
    a, r = shaper.pivot_distance, shaper.crank
    _comparable(shaper)
    if abs(r - a) <= CHANGE_POINT * a:
        raise InputError(
            "/crank_mm", r, f"The crank's pin passes through the guide's pivot, {a:g} mm from the "
            "crank's: a change point, where the guide may turn either way.",
            "Give a shorter crank for a rocking guide, or a longer one for a guide that makes full "
            "turns.",
        )  # fmt: skip
    low, high = shaper.guide_sine_range()
    worst = max((low, high), key=lambda sine: abs(shaper.coupler_sine(sine)))
    apart = abs(shaper.ram_line - shaper.guide * worst)
    if apart >= shaper.coupler:
        psi = math.asin(worst)
        phi = shaper.crank_at(psi, outer=True) / DEGREE
        upper, lower = shaper.guide * high, shaper.guide * low
        ways = f"Give a coupler of more than {apart:.6g} mm"
        if upper - lower < 2.0 * shaper.coupler:
            ways += (f", or a ram_line_mm between {upper - shaper.coupler:.6g} and "
                     f"{lower + shaper.coupler:.6g}")  # fmt: skip
        raise InputError(
            "/coupler_mm", shaper.coupler,
            f"At crank angle {phi:.6g}° the guide's end is {apart:.6g} mm from the ram's line, and "
            "the coupler does not reach it.", f"{ways}.",
        )  # fmt: skip


def _comparable(shaper: Shaper) -> None:
    """Refuse lengths so different that the ram's motion is lost in rounding."""
    lengths = {
        "crank_mm": shaper.crank, "guide_mm": shaper.guide, "coupler_mm": shaper.coupler,
        "pivot_distance_mm": shaper.pivot_distance,
    }  # fmt: skip
    shortest, longest = (pick(lengths, key=lambda name: lengths[name]) for pick in (min, max))
    if lengths[shortest] < SHORTEST * lengths[longest]:
        raise InputError(
            f"/{shortest}", lengths[shortest],
            f"It is less than a millionth of {longest} ({lengths[longest]:g} mm): the ram's motion "
            "would be lost in rounding.", f"Give at least {SHORTEST * lengths[longest]:g} mm.",
        )  # fmt: skip


def dead_centres(shaper: Shaper, drive: Drive) -> tuple[DeadCentre, ...]:
    """All dead centres of the ram, in the order in which the crank passes them."""
    found: list[DeadCentre] = []
    for phi, cause in _stationary_crank_angles(shaper):
        at = drive.turned(phi)
        ram = float(shaper.motion(np.array(phi)).ram[0])
        known = [round((at - one.turned) / FULL_TURN) * FULL_TURN + one.turned for one in found]
        if not any(abs(at - other) < SAME for other in known):
            found.append(DeadCentre(at, float(drive.phi(at)), ram, cause))
    return tuple(sorted(found, key=lambda one: one.turned))


def _stationary_crank_angles(shaper: Shaper) -> Iterator[tuple[float, str]]:
    """Crank angles at which x' = 0: ψ' = 0, or γ = ψ, or γ = ψ + π."""
    if not shaper.guide_rotates:
        for psi in (0.5 * math.pi - shaper.swing, 0.5 * math.pi + shaper.swing):
            # ψ' = 0: the crank is perpendicular to the guide.
            yield psi + math.copysign(0.5 * math.pi, psi - 0.5 * math.pi), "guide_turns_back"
    for along in (1.0, -1.0):
        length = shaper.guide + along * shaper.coupler
        if abs(shaper.ram_line) > abs(length) or length == 0.0:
            continue
        psi = math.asin(shaper.ram_line / length)
        for each in (psi, math.pi - psi):
            if along * math.cos(each) * SIGN[shaper.side] > 0.0:
                yield from ((phi, "in_line") for phi in _crank_angles(shaper, each))


def _crank_angles(shaper: Shaper, psi: float) -> Iterator[float]:
    """Crank angles at which the guide is at ψ; none outside its swing."""
    if shaper.guide_rotates:
        yield shaper.crank_at(psi, outer=True)
    elif math.sin(psi) >= math.cos(shaper.swing):
        yield from (shaper.crank_at(psi, outer) for outer in (True, False))


def extremes(
    shaper: Shaper, drive: Drive, quantities: Sequence[Quantity]
) -> list[tuple[Peak, Peak]]:
    """Largest and smallest value of each quantity over the turn, with proven enclosures.

    Taylor models of the loop equations over intervals of the crank angle; values in wire units.
    """
    count = len(quantities)
    whole = np.array([0])
    questions = [
        ExtremumQuery(whole, -np.inf, 0.0, function=k, relative=1e-10) for k in range(count)
    ]
    questions += [
        ExtremumQuery(whole, 0.0, np.inf, function=k, relative=1e-10) for k in range(count)
    ]

    def models(_: Any, lo: Array, hi: Array, wanted: Sequence[int]) -> list[Taylor]:
        centre = 0.5 * (lo + hi)
        half = 0.5 * (hi - lo) + 2.0**-50 * (np.abs(lo) + np.abs(hi))
        nothing = np.zeros_like(centre)
        turned = Taylor.of(centre, half, nothing, nothing)
        motion = shaper.motion(drive.phi(turned))
        return [quantities[k].of(motion, drive, turned) for k in wanted]

    found = enclose(models, np.array([0.0, FULL_TURN]), np.array([BOXES]), questions)
    both = zip(quantities, found[:count], found[count:], strict=True)
    return [
        (_peak(shaper, drive, quantity, high), _peak(shaper, drive, quantity, low))
        for quantity, high, low in both
    ]


def _peak(shaper: Shaper, drive: Drive, quantity: Quantity, answer: Extremum) -> Peak:
    """An enclosure in the wire's unit; where nothing was proven, the value at its angle."""
    found, value = answer.enclosure, answer.enclosure.value
    if not math.isfinite(value):
        value = float(quantity.of(shaper.motion(drive.phi(found.angle)), drive, found.angle))
    width = found.width / quantity.per_unit if math.isfinite(found.width) else None
    return Peak(value / quantity.per_unit, found.angle, width)


def coupler_range(shaper: Shaper) -> tuple[float, float]:
    """Smallest and largest angle of the coupler to the ram's line [rad], in closed form."""
    low, high = shaper.guide_sine_range()
    first, last = sorted(
        (math.asin(shaper.coupler_sine(high)), math.asin(shaper.coupler_sine(low)))
    )
    return first, last
