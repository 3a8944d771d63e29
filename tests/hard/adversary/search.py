"""Sequential linear programming with an exact penalty, from random starts.

Unknowns are those of the laws, the size, and the objective's own where it is a peak. Each step
minimises the linearised objective plus a price on the largest excess, inside a trust region; rows
that cannot bind there are left out. The best motion is then measured on finer samples, and limits
are tightened by what these show, so that nothing is exceeded between samples.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from scipy.optimize import linprog

from tests.hard.adversary.machine import ORDERS, Machine, Quantity
from tests.hard.adversary.motion import Program, Samples

PIECES = (10, 12, 16)  # of a law at first
DIVISIONS = 12  # times that pieces are divided, or limits tightened by what samples had missed
MOST = 100  # unknowns of laws that are divided further
PRICE = 30.0  # of the excess, against an objective of the order of 1
STEP = 1e-30  # of the complex differences
SMALLEST = 1e-7  # of the trust region
ROOM = 1e-7  # relative: kept of every limit
ROUNDING = 1e-9  # relative: of what is met exactly
HELD = "held_rms_jerk"  # key of a question: what its answer's own rms jerk is, in the wire's unit
SPANS = (2.0, 8.0, 60.0)  # of slope, curvature and jerk of a law: the unit of the trust region


@dataclass(frozen=True)
class Found:
    """Unknowns, the objective's value in the wire's unit, and the largest excess on samples."""

    program: Program
    machine: Machine
    laws: np.ndarray
    size: np.ndarray
    value: float
    excess: float


class Attack:
    """One question with all numbers given: its unknowns, objective and limits."""

    def __init__(self, program: Program) -> None:
        self.spec = spec = program.spec
        self.program = program
        self.machine = Machine(spec, self.program)
        question = spec.get("objective") or {"kind": "base_radius"}
        self.aim: str = (question[0] if isinstance(question, list) else question)["kind"]
        self.equations, self.values = self.program.joined()
        self.quantities = [*self.machine.quantities(), *self._peaks(), *self._held()]
        self.own_size = len(self.machine.numbers)
        self.count = self.program.count + self.own_size + 1
        self.samples = self.program.samples(6)
        self.fine = self.program.samples(25)
        self.moving = int(np.sum(self.fine.sense != 0.0))
        self.rooms = np.full(len(self.quantities) + 1, ROOM)  # the last: moving one way

    # -- the objective ---------------------------------------------------------------------------

    def _reference(self) -> float:
        """Unit of a peak: about the least between rests."""
        order = ORDERS.get(self.aim.split("_")[-1], 0)
        sharpest = [abs(p.lift) / p.beta**order for p in self.program.places if p.lift]
        return (4.0**order / 2.0 if order else 1.0) * max(sharpest, default=1.0) * self.program.unit

    def _peaks(self) -> list[Quantity]:
        """A peak that is to be small is a number z above all values."""
        unit, found = self._reference(), []
        for sign in (1.0, -1.0):
            if self.aim in ("peak_velocity", "peak_acceleration", "peak_jerk"):
                order = ORDERS[self.aim.split("_")[1]]
                found.append(Quantity("peak", lambda s, z, sign=sign, order=order: (
                    sign * s[order] / unit - z[-1])))  # fmt: skip
            if self.aim == "peak_pressure_angle" and "roller" in self.machine.kind:
                for i in range(2 if self.machine.closure["kind"] == "conjugate" else 1):

                    def over(s: Any, z: Any, sign: float = sign, i: int = i) -> Any:
                        one = self.machine.rollers(s, z)[i]
                        return (sign * one.across - z[-1] * one.along) / self.machine.length(z)

                    found += [Quantity("peak", over, (kind,)) for kind in ("rise", "return")]
        return found

    def _held(self) -> list[Quantity]:
        """The rms jerk that an answer leaves to the objective at hand, exactly: jerks are steps."""
        cap, weights = self.spec.get(HELD), np.zeros(self.program.count)
        if cap is None:
            return []
        for law in self.program.laws.values():
            lift, beta = law.place.lift, law.place.beta
            own = (lift * (self.program.omega / beta) ** 3 / cap) ** 2 * beta / (2.0 * np.pi)
            weights[law.first + 2 : law.first + law.count] = own * np.diff(law.breaks)

        def excess(laws: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            root = float(np.sqrt(weights @ laws**2)) or 1.0
            return np.array([root - 1.0]), (weights * laws / root)[None]

        return [Quantity("rms jerk", lambda s, z: z, functional=excess)]

    def objective(self, unknowns: np.ndarray) -> float:
        """What is to be small, of the order of 1."""
        laws, z = self.parts(unknowns)
        if self.aim == "base_radius":
            return float(np.real(self.machine.base(z))) / self.unit_length
        if self.aim.startswith("rms"):
            return float(np.sqrt(self._mean_square(laws))) / self._reference()
        return float(np.real(z[-1]))

    def slope(self, unknowns: np.ndarray) -> np.ndarray:
        """Gradient of the objective."""
        found, n = np.zeros(self.count), self.program.count
        laws, z = self.parts(unknowns)
        if self.aim == "base_radius":
            for k in range(self.own_size):
                bent = z.astype(complex)
                bent[k] += 1j * STEP
                found[n + k] = np.imag(self.machine.base(bent)) / STEP / self.unit_length
        elif self.aim.startswith("rms"):
            rms = np.sqrt(self._mean_square(laws))
            found[:n] = self._mean_square_slope(laws) / (2.0 * rms * self._reference())
        else:
            found[-1] = 1.0
        return found

    def _weights(self) -> np.ndarray:
        """Trapezoids between neighbouring samples."""
        theta = self.samples.theta
        gaps = np.diff(theta)
        return 0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps)) / (2.0 * np.pi)

    def _mean_square(self, laws: np.ndarray) -> float:
        values = self.samples.at(laws)[ORDERS[self.aim.split("_")[1]]]
        return float(self._weights() @ values**2)

    def _mean_square_slope(self, laws: np.ndarray) -> np.ndarray:
        order = ORDERS[self.aim.split("_")[1]]
        values = self.samples.at(laws)[order]
        return 2.0 * (self._weights() * values) @ self.samples.matrices[order]

    def wire_value(self, unknowns: np.ndarray) -> float:
        """The objective in the wire's unit."""
        value = self.objective(unknowns)
        if self.aim == "base_radius":
            return value * self.unit_length
        if self.aim == "peak_pressure_angle":
            return float(np.degrees(np.arctan(value)))
        order = ORDERS[self.aim.split("_")[1]]
        return value * self._reference() * self.program.omega**order / self.program.unit

    # -- limits ----------------------------------------------------------------------------------

    def parts(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return unknowns[: self.program.count], unknowns[self.program.count :]

    def rows(self, unknowns: np.ndarray, samples: Samples, slopes: bool) -> Any:
        """Values of all quantities and the room kept of them, and their derivatives."""
        laws, z = self.parts(unknowns)
        s = samples.at(laws)
        values, matrix = [], []
        for quantity, room in zip(self.quantities, self.rooms[:-1], strict=True):
            if quantity.functional is not None:
                excess, slope = quantity.functional(laws)
                values.append(excess + room)
                if slopes:
                    matrix.append(np.hstack([slope, np.zeros((len(slope), len(z)))]))
                continue
            chosen = np.isin(samples.kind, quantity.kinds) if quantity.kinds else slice(None)
            own = [row[chosen] for row in s]
            if not len(own[0]):
                continue
            if not quantity.kinds and quantity.name in ("base above 0", "least base",
                                                        "largest base"):  # fmt: skip
                own, chosen = [row[:1] for row in own], slice(0, 1)
            values.append(np.real(quantity.value(own, z)) + room)
            if not slopes:
                continue
            block = np.zeros((len(values[-1]), self.count))
            for n in range(4):
                bent = [row.astype(complex) for row in own]
                bent[n] += 1j * STEP
                by = np.imag(quantity.value(bent, z)) / STEP
                if np.any(by):
                    block[:, : self.program.count] += by[:, None] * samples.matrices[n][chosen]
            for k in range(len(z)):
                moved = z.astype(complex)
                moved[k] += 1j * STEP
                block[:, self.program.count + k] = np.imag(quantity.value(own, moved)) / STEP
            matrix.append(block)
        # free laws without overshoot move one way; at rest they do so without room
        sense = samples.sense[one_way := samples.sense != 0.0] / self.machine.stroke
        room = self.rooms[-1] * samples.inside[one_way] - ROUNDING
        values.append(room - sense * s[1][one_way])
        if slopes:
            block = np.zeros((len(sense), self.count))
            block[:, : self.program.count] = -sense[:, None] * samples.matrices[1][one_way]
            matrix.append(block)
        found = np.concatenate(values)
        return found, (np.concatenate(matrix) if slopes else None)

    # -- starts ----------------------------------------------------------------------------------

    def start(self, random: np.random.Generator, hint: float | None) -> np.ndarray:
        """Random size and laws that join; ``hint``: a base radius to begin near [mm]."""
        laws = np.zeros(self.program.count)
        if self.program.count:
            wanted = laws.copy()
            for law in self.program.laws.values():  # 3-4-5, more or less bent
                middle = 0.5 * (law.breaks[1:] + law.breaks[:-1])
                own = 60.0 - 360.0 * middle + 360.0 * middle**2
                if law.order == 2:
                    own = 60.0 * middle - 180.0 * middle**2 + 120.0 * middle**3
                bent = own * random.uniform(0.5, 1.5, len(own))
                wanted[law.first + law.order - 1 : law.first + law.count] = bent
            step, *_ = np.linalg.lstsq(
                self.equations, self.values - self.equations @ wanted, rcond=None
            )
            laws = wanted + step
        z = []
        for number in self.machine.numbers:
            low, high = number.low, number.high
            if hint is not None and number.name in ("height", "base"):
                low, high = 0.3 * hint + 1e-12, 3.0 * hint
                low, high = max(low, number.least), min(high, number.most)
            if high > low > 0.0 and high > 10.0 * low:
                z.append(float(np.exp(random.uniform(np.log(low), np.log(high)))))
            else:
                z.append(float(random.uniform(low, high)) if high > low else low)
        self.unit_length = max(self.machine.length(np.array([*z, 1.0])), 1e-12)
        if hint is not None:
            self.unit_length = hint
        return np.array([*laws, *z, 2.0])

    def spans(self, unknowns: np.ndarray) -> np.ndarray:
        """Unit of the trust region of every unknown."""
        found = np.ones(self.count)
        for law in self.program.laws.values():
            found[law.first : law.first + law.order - 1] = SPANS[: law.order - 1]
            found[law.first + law.order - 1 : law.first + law.count] = SPANS[law.order - 1]
        _, z = self.parts(unknowns)
        for k, number in enumerate(self.machine.numbers):
            angle = number.name in ("angle", "between")
            found[self.program.count + k] = 1.0 if angle else self.machine.length(z)
        return found

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        low, high = np.full(self.count, -inf), np.full(self.count, inf)
        for k, number in enumerate(self.machine.numbers):
            low[self.program.count + k], high[self.program.count + k] = number.least, number.most
        low[-1] = 0.0
        return low, high

    def divided(self, unknowns: np.ndarray) -> tuple[np.ndarray, Attack]:
        """The same cam and limits on other pieces."""
        laws, z = self.parts(unknowns)
        program, moved = self.program.divided(laws)
        other = Attack(program)
        other.unit_length = self.unit_length
        other.rooms = np.maximum(0.3 * self.rooms, ROOM)
        return np.concatenate([moved, z]), other

    # -- the descent -----------------------------------------------------------------------------

    def descend(self, unknowns: np.ndarray, stop: float, aim: bool) -> np.ndarray:
        """Steps until the trust region is small; with ``aim`` the objective counts, too."""
        least, most = self.bounds()
        radius, price = 0.3, PRICE
        values, matrix = self.rows(unknowns, self.samples, slopes=True)
        worth = self._merit(unknowns, values, price, aim)
        while radius > SMALLEST and time.process_time() < stop:
            spans = self.spans(unknowns) * radius
            step = self._step(unknowns, values, matrix, spans, least, most, price, aim)
            if step is None:
                radius *= 0.25
                continue
            ahead = unknowns + step
            tried, _ = self.rows(ahead, self.samples, slopes=False)
            merit = self._merit(ahead, tried, price, aim)
            if not merit < worth - 1e-12:
                radius *= 0.3
                continue
            if worth - merit < 1e-9 * (1.0 + abs(worth)):
                radius *= 0.3
            else:
                radius = min(2.0 * radius, 1.0)
            unknowns = ahead
            values, matrix = self.rows(unknowns, self.samples, slopes=True)
            worth = merit
            if not aim and worth <= 0.0:
                break
        return unknowns

    def _merit(self, unknowns: np.ndarray, excess: np.ndarray, price: float, aim: bool) -> float:
        if not np.all(np.isfinite(excess)):
            return inf
        over = max(float(np.max(excess, initial=-inf)), 0.0)
        return (self.objective(unknowns) if aim else 0.0) + price * over

    def _step(
        self, unknowns: np.ndarray, values: np.ndarray, matrix: np.ndarray, spans: np.ndarray,
        least: np.ndarray, most: np.ndarray, price: float, aim: bool,
    ) -> np.ndarray | None:  # fmt: skip
        """Solution of the linear program around a point."""
        scaled = matrix * spans
        active = values + np.sum(np.abs(scaled), axis=1) > 0.0
        cost = np.append(self.slope(unknowns) * spans if aim else np.zeros(self.count), price)
        low = np.maximum((least - unknowns) / spans, -1.0)
        high = np.minimum((most - unknowns) / spans, 1.0)
        if np.any(low > high) or not np.all(np.isfinite(scaled)):
            return None
        equations = np.zeros((len(self.values), self.count + 1))
        equations[:, : self.program.count] = self.equations * spans[: self.program.count]
        own = self.values - self.equations @ unknowns[: self.program.count]
        found = linprog(
            cost,
            A_ub=np.hstack([scaled[active], -np.ones((int(np.sum(active)), 1))]),
            b_ub=-values[active],
            A_eq=equations if len(own) else None,
            b_eq=own if len(own) else None,
            bounds=[*zip(low, high, strict=True), (0.0, None)],
            method="highs",
            options={"primal_feasibility_tolerance": 1e-9},
        )
        return None if found.x is None else found.x[:-1] * spans

    def finished(self, unknowns: np.ndarray) -> Found:
        """Value and excess on finer samples; each limit is tightened by what it was exceeded."""
        laws, z = self.parts(unknowns)
        worst, rooms, quantities = -inf, self.rooms, self.quantities
        self.rooms = np.zeros(len(rooms))
        for i in range(len(rooms)):
            self.quantities = quantities[i : i + 1]
            self.rooms = np.array([0.0, 0.0] if self.quantities else [0.0])
            values, _ = self.rows(unknowns, self.fine, slopes=False)
            if self.quantities:
                values = values[: len(values) - self.moving]
            excess = float(np.max(values, initial=-inf))
            worst, rooms[i] = max(worst, excess), rooms[i] + 1.3 * max(excess, 0.0)
        self.quantities, self.rooms = quantities, rooms
        return Found(self.program, self.machine, laws, z, self.wire_value(unknowns), worst)


def cams(
    spec: dict[str, Any], seconds: float, seed: int, hint: float | None, aim: bool,
    take: Callable[[Found], bool],
) -> None:  # fmt: skip
    """Search for cams of a question; each that keeps its limits on fine samples is handed over.

    Args:
        spec: all its numbers given but for the size. seconds: of processor time. hint: a base
            radius [mm] to begin near. aim: whether small ones are sought, or any. take: what is
            done with a cam; the search ends where it says so.
    """
    random, stop = np.random.default_rng(seed), time.process_time() + seconds
    while time.process_time() < stop:
        count = int(random.choice(PIECES))
        program = Program(spec, lambda index, count=count: _breaks(count, random))
        attack = Attack(program)
        at = attack.start(random, hint if random.random() < 0.7 else None)
        at = attack.descend(at, stop, aim=False)
        for _ in range(DIVISIONS):
            if aim:
                at = attack.descend(at, stop, aim=True)
            found = attack.finished(at)
            if found.excess <= 0.0:
                if take(found):
                    return
                if not 0 < attack.program.count < MOST:
                    break
                at, attack = attack.divided(at)
            elif not aim:
                at = attack.descend(at, stop, aim=False)


def _breaks(count: int, random: np.random.Generator) -> np.ndarray:
    """Nearly even pieces: no optimum has its jumps at even places."""
    found = np.linspace(0.0, 1.0, count + 1)
    found[1:-1] += random.uniform(-0.4, 0.4, count - 1) / count
    return found
