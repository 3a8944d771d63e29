"""Textbook formulas of every follower, sample by sample, with derivatives by complex steps.

Sources: VDI 2143, Norton, *Cam Design and Manufacturing Handbook*. A roller's centre at (x, y)
in the machine moves past the cam, which turns by one radian per unit of time, at
(x' + y, y' − x); its acceleration on the cam is (x'' + 2y' − x, y'' − 2x' − y).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product
from math import cos, inf, pi, radians, sin
from typing import Any

import numpy as np

from tests.hard.adversary.motion import Program
from tests.hard.own_cam import base_gap, sides

Values = np.ndarray
State = list[Values]  # s, s', s'', s''' per radian [mm or rad]
ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}
MET = 2e-7  # relative: of a base radius that is given
GRAVITY = 9.80665  # m/s²
DIRECTIONS = 48  # of an amplitude: 0.2 % of the largest one is lost


@dataclass(frozen=True)
class Quantity:
    """What must not be positive, at the samples of some kinds of segments.

    ``value(s, z)``: of the order of 1, smooth, complex where s or z is. ``functional``: where it is
    of whole laws: values (n,) and derivatives by their unknowns (n, unknowns).
    """

    name: str
    value: Callable[[State, Values], Values]
    kinds: tuple[str, ...] = ()
    functional: Callable[[Values], tuple[Values, Values]] | None = None


@dataclass(frozen=True)
class Number:
    """A size variable and its range; starts lie between ``low`` and ``high``."""

    name: str
    least: float
    most: float
    low: float
    high: float


@dataclass(frozen=True)
class Roller:
    """Path of a roller's centre in the machine; tan of the pressure angle is across / along."""

    place: tuple[Values, Values]
    speed: tuple[Values, Values]
    acceleration: tuple[Values, Values]
    across: Values
    along: Values

    @property
    def passing(self) -> tuple[Values, Values]:
        """Velocity past the cam."""
        (x, y), (x1, y1) = self.place, self.speed
        return x1 + y, y1 - x

    @property
    def curvature(self) -> Values:
        (x, y), (x1, y1), (x2, y2) = self.place, self.speed, self.acceleration
        (a, b), c, f = self.passing, x2 + 2.0 * y1 - x, y2 - 2.0 * x1 - y
        return (b * c - a * f) / (a * a + b * b) ** 1.5

    def offset_point(self, distance: float) -> Values:
        """Squared radius of the point at a distance inward along the normal."""
        (x, y), (a, b) = self.place, self.passing
        speed = (a * a + b * b) ** 0.5
        px, py = x + distance * b / speed, y - distance * a / speed
        return px * px + py * py


class Machine:
    """A follower: its size variables, and every limit of a spec as quantities."""

    def __init__(self, spec: dict[str, Any], program: Program) -> None:
        self.spec, self.follower, self.program = spec, spec["follower"], program
        self.kind: str = self.follower["kind"]
        self.closure = self.follower.get("closure") or {"kind": "force"}
        self.sense = {"opposite": 1.0, "same": -1.0}[self.follower.get("sense", "opposite")]
        self.gap = base_gap(spec)
        self.numbers = list(self._numbers())
        self.stroke = max(program.stroke, 1e-12)

    # -- size ----------------------------------------------------------------------------------

    def _numbers(self) -> Iterator[Number]:
        follower, stroke = self.follower, max(self.program.stroke, 1e-12)
        pair = self.closure["kind"] == "conjugate"
        if self.kind == "translating_roller":
            yield _number("offset", follower.get("offset_mm"), -2.0 * stroke, 2.0 * stroke, -inf)
            yield Number("height", 1e-9 * stroke, inf, 0.05 * stroke, 30.0 * stroke)
            if pair:
                far = self.closure.get("distance_mm")
                yield _number("distance", far, 2.0 * stroke, 40.0 * stroke)
        elif self.kind == "translating_flat_face":
            yield Number("base", 1e-12 * stroke, inf, 0.05 * stroke, 60.0 * stroke)
        else:
            swing, question = self.program.stroke, follower.get("initial_angle_deg")
            last = (pi if self.kind == "oscillating_roller" else 0.5 * pi) - swing - 1e-4
            angle = _number("angle", _scaled(question, radians(1.0)), 0.02, max(0.03, last))
            yield Number("angle", max(angle.least, 1e-4), min(angle.most, last), angle.low, last)
            reach = follower.get("arm_mm") or 100.0
            yield _number("centre", follower.get("centre_distance_mm"), 0.5 * reach, 3.0 * reach)
            if pair:
                between = _scaled(self.closure.get("angle_deg"), radians(1.0))
                yield _number("between", between, swing + 0.1, pi)

    def base(self, z: Values) -> Values:
        """Base radius [mm]."""
        if self.kind == "translating_roller":
            return (z[0] * z[0] + z[1] * z[1]) ** 0.5 - self.gap
        if self.kind == "translating_flat_face":
            return z[0]
        if self.kind == "oscillating_flat_face":
            return z[1] * np.sin(z[0]) - self.follower.get("face_offset_mm", 0.0)
        arm = self.follower["arm_mm"]
        squared = z[1] * z[1] + arm * arm - 2.0 * z[1] * arm * np.cos(z[0])
        return squared**0.5 - self.gap

    def wire(self, z: Values) -> dict[str, float]:
        """The size as dimensions of an answer."""
        found = {"base_radius_mm": float(self.base(z))}
        if self.kind == "translating_roller":
            found |= {"offset_mm": float(z[0]), "s0_mm": float(z[1])}
            if self.closure["kind"] == "conjugate":
                found["counter_distance_mm"] = float(z[2])
        elif self.kind != "translating_flat_face":
            found |= {"initial_angle_deg": float(np.degrees(z[0]))}
            found |= {"centre_distance_mm": float(z[1])}
            if self.closure["kind"] == "conjugate":
                found["counter_angle_deg"] = float(np.degrees(z[2]))
        return found

    def length(self, z: Values) -> float:
        """A length of the order of the cam's, to compare others with [mm]."""
        lengths = [float(np.real(v)) for v, n in zip(z, self.numbers, strict=False)
                   if n.name in ("offset", "height", "base", "centre")]  # fmt: skip
        slide = 0.0 if self.kind.startswith("osc") else self.stroke
        return max(float(np.hypot.reduce(lengths)), slide, 1e-12)

    # -- paths ---------------------------------------------------------------------------------

    def rollers(self, s: State, z: Values) -> list[Roller]:
        zero, pair = 0.0 * s[0], self.closure["kind"] == "conjugate"
        found: list[Roller] = []
        if self.kind == "translating_roller":
            heights = [(z[0], z[1] + s[0], 1.0)]
            if pair:
                below = z[1] + s[0] - z[2]
                heights.append((self.closure.get("offset_mm", 0.0), below, -1.0))
            for e, y, up in heights:
                found.append(Roller((e + zero, y), (zero, s[1]), (zero, s[2]), s[1] - e, up * y))
            return found
        arms = [(self.follower["arm_mm"], z[0] + s[0], 1.0)]
        if pair:
            arms.append((self.closure["arm_mm"], z[2] - z[0] - s[0], -1.0))
        for arm, psi, turn in arms:
            d, sense, p1, p2 = z[1], turn * self.sense, turn * s[1], turn * s[2]
            c, n = np.cos(psi), np.sin(psi)
            place = d - arm * c, sense * arm * n
            speed = arm * n * p1, sense * arm * c * p1
            bent = arm * (c * p1 * p1 + n * p2), sense * arm * (c * p2 - n * p1 * p1)
            found.append(Roller(place, speed, bent, arm * (1.0 + sense * p1) - d * c, d * n))
        return found

    def face(self, s: State, z: Values) -> tuple[Values, Values, Values]:
        """Profile radius, support function, and where the face touches along itself."""
        if self.kind == "translating_flat_face":
            tilt, c = radians(self.follower.get("tilt_deg", 0.0)), self.follower.get("offset_mm", 0)
            h = z[0] + s[0] * cos(tilt)
            along = s[1] * cos(tilt) - c * cos(tilt) - (h + c * sin(tilt)) * np.tan(tilt)
            return h + s[2] * cos(tilt), h, along
        psi, d, turn = z[0] + s[0], z[1], 1.0 + self.sense * s[1]
        h = d * np.sin(psi) - self.follower.get("face_offset_mm", 0.0)
        h1 = d * np.cos(psi) * s[1]
        h2 = d * (np.cos(psi) * s[2] - np.sin(psi) * s[1] * s[1])
        return h + (h2 * turn - h1 * self.sense * s[2]) / turn**3, h, d * np.cos(psi) / turn

    # -- limits --------------------------------------------------------------------------------

    def quantities(self) -> Iterator[Quantity]:
        """Every limit, and what always holds."""
        limits = list(self.spec.get("limits", []))
        if not any(limit["kind"] == "profile_radius" for limit in limits):
            limits.append({"kind": "profile_radius", "min_mm": 0.0})
        for limit in limits:
            yield from getattr(self, f"_{limit['kind']}")(limit)
        yield from self._standing()

    def _standing(self) -> Iterator[Quantity]:
        question = self.spec.get("base_radius_mm")
        least, most = (question, question) if isinstance(question, (int, float)) else (
            (question or {}).get("min"), (question or {}).get("max"))  # fmt: skip
        one = lambda v, s: v + 0.0 * s[0]  # noqa: E731
        yield Quantity("base above 0", lambda s, z: one(-self.base(z) / self.length(z), s))
        met = MET if least == most else 0.0
        if least is not None:
            yield Quantity("least base", lambda s, z: one(1.0 - met - self.base(z) / least, s))
        if most is not None:
            yield Quantity("largest base", lambda s, z: one(self.base(z) / most - 1.0 - met, s))
        if self.kind == "oscillating_flat_face":
            yield Quantity("face turns", lambda s, z: 2e-3 - 1.0 - self.sense * s[1])
        elif "roller" in self.kind:
            for i in range(2 if self.closure["kind"] == "conjugate" else 1):
                yield Quantity("stands", lambda s, z, i=i: (
                    -self.rollers(s, z)[i].along / self.length(z)))  # fmt: skip
            if self.closure["kind"] == "conjugate":
                yield from self._counter_base_radius({"min_mm": 0.0})

    def _pressure_angle(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        for kind in ("rise", "return", "dwell"):
            if limit.get(f"{kind}_deg") is not None:
                most = radians(limit[f"{kind}_deg"])
                for i, sign in product(range(self._paths()), (1.0, -1.0)):
                    yield Quantity("pressure angle", lambda s, z, i=i, sign=sign, most=most: (
                        self._leaning(s, z, i, sign, most)), (kind,))  # fmt: skip

    def _leaning(self, s: State, z: Values, i: int, sign: float, most: float) -> Values:
        if self.kind == "translating_flat_face":
            return abs(radians(self.follower.get("tilt_deg", 0.0))) - most + 0.0 * s[0]
        if self.kind == "oscillating_flat_face":  # the force acts at the height f over the radius
            f, (_, _, along) = self.follower.get("face_offset_mm", 0.0), self.face(s, z)
            return (sign * f * cos(most) - along * sin(most)) / self.length(z)
        one = self.rollers(s, z)[i]
        return (sign * one.across * cos(most) - one.along * sin(most)) / self.length(z)

    def _paths(self) -> int:
        return 2 if self.closure["kind"] == "conjugate" else 1

    def _profile_radius(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        least = limit.get("min_mm", 0.0)
        if "roller" not in self.kind:
            yield Quantity("profile radius", lambda s, z: (
                least - self.face(s, z)[0]) / max(self.length(z), least))  # fmt: skip
        for flank in sides(self.spec):
            if flank.distance + least > 0.0:
                i, reach = int(flank.path == "counter"), flank.distance + least
                yield Quantity("profile radius", lambda s, z, i=i, reach=reach, side=flank.side: (
                    side * self.rollers(s, z)[i].curvature * reach - 1.0))  # fmt: skip

    def _cutter_radius(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        for flank in sides(self.spec):
            reach = limit["radius_mm"] - flank.distance
            if reach > 0.0:
                i = int(flank.path == "counter")
                yield Quantity("cutter radius", lambda s, z, i=i, reach=reach, side=flank.side: (
                    -side * self.rollers(s, z)[i].curvature * reach - 1.0))  # fmt: skip

    def _outer_radius(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        most = limit["max_mm"]
        for flank in sides(self.spec):
            i, inward = int(flank.path == "counter"), flank.side * flank.distance - flank.rim
            yield Quantity("outer radius", lambda s, z, i=i, inward=inward: (
                self.rollers(s, z)[i].offset_point(inward) / most**2 - 1.0))  # fmt: skip
        if "roller" not in self.kind:

            def across(s: State, z: Values) -> Values:
                slope = s[1] * cos(radians(self.follower.get("tilt_deg", 0.0)))
                if self.kind.startswith("osc"):
                    slope = z[1] * np.cos(z[0] + s[0]) * s[1] / (1.0 + self.sense * s[1])
                return (self.face(s, z)[1] ** 2 + slope**2) / most**2 - 1.0

            yield Quantity("outer radius", across)

    def _counter_base_radius(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        for flank in sides(self.spec)[1:]:
            if self.closure["kind"] == "conjugate":
                least = flank.distance + limit.get("min_mm", 0.0)
                yield Quantity("counter base", lambda s, z, least=least: least / (
                    self.rollers(s, z)[1].offset_point(0.0) ** 0.5) - 1.0)  # fmt: skip

    def _face_width(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        half = None if limit.get("width_mm") is None else 0.5 * limit["width_mm"]
        ends = [(limit.get("far_mm"), 1.0), (limit.get("near_mm"), -1.0)]
        if self.kind == "translating_flat_face":
            ends = [(limit.get("left_mm"), -1.0), (limit.get("right_mm"), 1.0), (half, 1.0),
                    (half, -1.0)]  # fmt: skip
        for most, sign in ends:
            if most is not None:
                bound = -most if sign < 0.0 and self.kind.startswith("osc") else most
                yield Quantity("face width", lambda s, z, bound=bound, sign=sign: (
                    (sign * self.face(s, z)[2] - bound)
                    / max(self.length(z), abs(bound))))  # fmt: skip

    def _derivative(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        order = ORDERS[limit["kind"]]
        most = next(value for key, value in limit.items() if key.startswith("max_") and value)
        scale = self.program.omega**order / (most * self.program.unit)
        for sign in (1.0, -1.0):
            yield Quantity(limit["kind"], lambda s, z, sign=sign: sign * scale * s[order] - 1.0)

    def _residual_vibration(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        most = next(value for key, value in limit.items() if key.startswith("max_") and value)
        swings = 2.0 * pi * limit["natural_frequency_hz"] / self.program.omega

        turns = 2.0 * pi * np.arange(DIRECTIONS) / DIRECTIONS
        directions = np.stack([np.cos(turns), np.sin(turns)], axis=1) / cos(pi / DIRECTIONS)

        def excess(laws: Values, matrix: Values, constants: Values) -> tuple[Values, Values]:
            return matrix @ laws + constants - 1.0, matrix

        # Linear in the unknowns: a polygon inside the circle of the largest amplitude.
        for matrix, constants in self.program.ringing(swings, limit.get("damping_ratio", 0.0)):
            yield Quantity("residual vibration", lambda s, z: 0.0 * s[0], (), partial(
                excess, matrix=directions @ matrix / most,
                constants=directions @ constants / most))  # fmt: skip

    _velocity = _acceleration = _jerk = _derivative

    # -- forces --------------------------------------------------------------------------------

    def drive(self, s: State) -> Values:
        """Force along a slide [N]: inertia, damping, spring, weight."""
        load, omega = self.spec["load"], self.program.omega
        spring = load.get("spring") or {}
        weight = load.get("rise_from_vertical_deg")
        mass = load.get("moving_mass_kg", 0.0)
        found = 1e-3 * (mass * omega**2 * s[2] + load.get("damping_n_s_per_m", 0.0) * omega * s[1])
        found = found + spring.get("rate_n_per_mm", 0.0) * s[0] + spring.get("preload_n", 0.0)
        return found if weight is None else found + mass * GRAVITY * cos(radians(weight))

    def modelled(self) -> bool:
        """Whether every limit has a formula here."""
        load, limits = self.spec.get("load"), self.spec.get("limits", [])
        known = all(hasattr(self, f"_{limit['kind']}") for limit in limits)
        plain = {"kind", "moving_mass_kg", "damping_n_s_per_m", "spring", "contact",
                 "rise_from_vertical_deg"}  # fmt: skip
        numbers = [v for v in ((load or {}).get("spring") or {}).values() if not _is_number(v)]
        force = self.closure["kind"] == "force" and self.closure.get("contact") != "inside"
        slides = self.kind.startswith("translating") and force and not numbers
        inside = [s for s in self.spec["program"] if s.get("windows") or s.get("points")]
        inside += [s for s in self.spec["program"] if s.get("start") or s.get("end")]
        silent = [one for one in limits if one["kind"] == "residual_vibration"
                  and not (one.get("max_mm") or one.get("max_deg"))]  # fmt: skip
        return (
            known
            and not inside
            and not silent
            and (load is None or (plain >= set(load) and slides))
        )

    def _contact_force(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        tilt = cos(radians(self.follower.get("tilt_deg", 0.0)))

        def lean(s: State, z: Values) -> Values:
            if "roller" not in self.kind:
                return tilt + 0.0 * s[0]
            one = self.rollers(s, z)[0]
            return one.along / (one.along**2 + one.across**2) ** 0.5

        reference = self._reference_force()
        if limit.get("min_n") is not None:
            yield Quantity("contact force", lambda s, z: (
                limit["min_n"] * lean(s, z) - self.drive(s)) / reference)  # fmt: skip
        if limit.get("max_n") is not None:
            yield Quantity("contact force", lambda s, z: (
                self.drive(s) / (limit["max_n"] * lean(s, z)) - 1.0))  # fmt: skip

    def _reference_force(self) -> float:
        still = [np.zeros(1), np.zeros(1), np.full(1, 4.0 * self.stroke), np.zeros(1)]
        return max(float(np.abs(self.drive(still))[0]), 1e-9)

    def _camshaft_torque(self, limit: dict[str, Any]) -> Iterator[Quantity]:
        for sign in (1.0, -1.0):
            yield Quantity("torque", lambda s, z, sign=sign: (
                sign * 1e-3 * self.drive(s) * s[1] / limit["max_n_m"] - 1.0))  # fmt: skip


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float))


def _scaled(question: Any, factor: float) -> Any:
    if isinstance(question, dict):
        return {key: None if value is None else value * factor for key, value in question.items()}
    return None if question is None else question * factor


def _number(name: str, question: Any, low: float, high: float, floor: float = 1e-9) -> Number:
    """A size variable, given, in a range, or open."""
    if _is_number(question):
        return Number(name, question, question, question, question)
    least, most = (question or {}).get("min"), (question or {}).get("max")
    least, most = floor if least is None else least, inf if most is None else most
    low, high = max(low, least), min(high, most)
    return Number(name, least, most, *((low, high) if low <= high else (least, least)))
