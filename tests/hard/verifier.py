"""An independent verifier: wire in, complaints out. It imports nothing of the product.

``verify(spec, design)`` takes the two JSON bodies, rebuilds motion and geometry by formulas of its
own (``own_laws``, ``own_cam``), samples every piece densely, refines around the extremes, and says
in words whatever a design claims and does not keep.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite, pi
from typing import Any

import numpy as np

from tests.hard.own_cam import (
    RAD,
    Face,
    Path,
    PlacedSegment,
    base_gap,
    paths,
    segments,
    sides,
    unit_of,
)
from tests.hard.own_ringing import amplitudes

Quantity = Callable[[list[np.ndarray]], np.ndarray]
ALWAYS = "always"
ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}


@dataclass(frozen=True)
class Reading:
    """A limit measured here: value ≤ bound must hold (both may be infinite)."""

    name: str
    value: float
    bound: float
    slack: float  # what rounding can make of it
    wire: Callable[[float], float | None] = lambda value: value
    scale: float = 0.0  # a length of the cam, beside which values are told apart

    @property
    def broken(self) -> bool:
        return not self.value <= self.bound + self.slack

    @property
    def kept_clearly(self) -> bool:
        room = max(1e-7 * abs(self.bound), 10.0 * self.slack)
        return self.value < self.bound - room


class Cam:
    """A motion and a size, to be asked for extremes."""

    def __init__(
        self,
        spec: dict[str, Any],
        moves: list[PlacedSegment],
        size: dict[str, float],
        dense: int = 24,
    ) -> None:
        self.spec, self.moves, self.fine = spec, moves, dense > 20
        self._joints: dict[int, list[tuple[float, float, float, float]]] = {}
        self.peaks: dict[int, float] = {}
        self.omega = spec.get("speed_rpm", 60.0) * pi / 30.0
        self.unit = unit_of(spec)
        self._take(size)
        self.grids: list[tuple[PlacedSegment, int, np.ndarray]] = []
        for move in moves:
            if move.kind == "dwell":
                self.grids.append((move, 0, np.array([0.0, 0.5, 1.0])))
                continue
            count = max(dense, (12 * dense) // len(move.pieces))
            for i, (a, b, _) in enumerate(move.pieces):
                self.grids.append((move, i, np.linspace(a, b, count)))

    def _take(self, size: dict[str, float]) -> None:
        self.size = size
        # length of one unit of lift, for a sense of size
        reach = self.spec["follower"].get("arm_mm") or size.get("centre_distance_mm", 1.0)
        self.per_unit = reach * RAD if self.unit == "deg" else 1.0

    def sized(self, size: dict[str, float]) -> Cam:
        """The same motion in another size: what is known of the motion stays known."""
        other = copy(self)
        other._take(size)
        return other

    def look_at(self, degrees: Iterable[float]) -> None:
        """Sample these cam angles too: a spike may be narrower than the grid."""
        where = np.radians(np.array(sorted(set(degrees)))) % (2.0 * pi)
        where = np.concatenate([where - 1e-7, where, where + 1e-7])
        for k, (move, piece, x) in enumerate(self.grids):
            at = (where - move.start) / move.beta
            at = at[(at > x[0]) & (at < x[-1])]
            if len(at):
                self.grids[k] = (move, piece, np.union1d(x, at))

    @cached_property
    def sampled(self) -> tuple[list[np.ndarray], np.ndarray]:
        """s and its derivatives at all samples in a row, and where each grid begins."""
        rows = [self.s(*grid) for grid in self.grids]
        starts = np.cumsum([0, *(len(x) for *_, x in self.grids)])
        return [np.concatenate([row[n] for row in rows]) for n in range(4)], starts

    def s(self, move: PlacedSegment, piece: int, x: np.ndarray) -> list[np.ndarray]:
        return [move.at(piece, x, n) for n in range(4)]

    def largest(self, quantity: Quantity, kinds: Iterable[str] = ()) -> float:
        """The largest value over the turn, or over segments of these kinds."""
        s, starts = self.sampled
        values, best = np.array(quantity(s), dtype=float), -inf
        tops = np.maximum.reduceat(values, starts[:-1])
        if kinds:
            tops = np.where([move.kind in kinds for move, *_ in self.grids], tops, -inf)
        # the best pieces, each searched again and again around its top
        for top in np.argsort(-tops, kind="stable")[: 12 if self.fine else 2]:
            if tops[top] == -inf:
                continue
            best = max(
                best, self._top(quantity, *self.grids[top], values[starts[top] : starts[top + 1]])
            )
        return best

    def _top(
        self, quantity: Quantity, move: PlacedSegment, piece: int, x: np.ndarray, values: np.ndarray
    ) -> float:
        """The largest value on a piece, searched again and again around that of its samples."""
        best = float(np.max(values))
        for _ in range(4 if self.fine else 1):
            at = int(np.argmax(values))
            x = np.linspace(x[max(at - 1, 0)], x[min(at + 1, len(x) - 1)], 21)
            values = np.asarray(quantity(self.s(move, piece, x)), dtype=float)
            best = max(best, float(np.max(values)))
        return best

    def largest_within(self, index: int, low: float, high: float, quantity: Quantity) -> float:
        """The largest value on a part of a segment, low ≤ x ≤ high; of a point low = high."""
        best = -inf
        for move, piece, x in self.grids:
            touches = x[0] <= high and low <= x[-1]
            if (
                move.index == index
                and touches
                and (min(high, x[-1]) > max(low, x[0]) or low == high)
            ):
                ends = max(low, x[0]), min(high, x[-1])
                inside = np.union1d(ends, x[(x > ends[0]) & (x < ends[1])])
                values = np.asarray(quantity(self.s(move, piece, inside)), dtype=float)
                best = max(best, self._top(quantity, move, piece, inside, values))
        return best

    def jump(self, order: int) -> tuple[float, float]:
        """Largest jump of the n-th derivative at joints and breaks, and what rounding may make."""
        worst, noise = 0.0, 0.0
        for before, after, scale, rounding in self.joints(order):
            if abs(after - before) - 2e-9 * scale - rounding > worst - noise:
                worst, noise = abs(after - before), 2e-9 * scale + rounding
        return worst, noise

    def joints(self, order: int) -> list[tuple[float, float, float, float]]:
        """(before, after, scale, rounding) at every joint of two pieces, round the turn."""
        if order not in self._joints:
            self._joints[order] = list(self._joined(order))
        return self._joints[order]

    def _joined(self, order: int) -> Iterable[tuple[float, float, float, float]]:
        starts = [float(move.at(i, x[:1], order)[0]) for move, i, x in self.grids]
        ends = [float(move.at(i, x[-1:], order)[0]) for move, i, x in self.grids]
        size = {m.index: abs(m.lift) / m.beta**order for m in self.moves}
        level = 1e-14 * max(m.level + max(m.lift, 0.0) for m in self.moves) if order == 0 else 0.0
        moves = [move for move, *_ in self.grids]
        for k, (left, right) in enumerate(zip(moves, [*moves[1:], moves[0]], strict=True)):
            rounding = sum(size[m.index] * m.noise[order] for m in (left, right))
            after = starts[(k + 1) % len(starts)]
            scale = max(size[left.index], size[right.index])
            yield ends[k], after, scale, rounding + level

    def path(self, index: int, s: list[np.ndarray]) -> Path:
        return paths(self.spec, self.size, s)[index]

    def names(self) -> list[str]:
        still = [np.zeros(1)] * 4
        return [path.name for path in paths(self.spec, self.size, still)]

    def noise(self, order: int) -> float:
        """Rounding of the n-th derivative per radian."""
        return max(abs(m.lift) / m.beta**order * m.noise[order] for m in self.moves)


# -- limits --------------------------------------------------------------------------------------


def readings(cam: Cam) -> Iterator[Reading]:
    """Every limit of the spec and every rule that always holds, measured on the cam in turn."""
    kinds = {limit["kind"] for limit in cam.spec.get("limits", [])}
    limits = list(cam.spec.get("limits", []))
    if "profile_radius" not in kinds:
        limits.append({"kind": "profile_radius", "min_mm": 0.0})
    if "counter_base_radius" not in kinds and len(cam.names()) > 1:
        limits.append({"kind": "counter_base_radius", "min_mm": 0.0})
    limits.sort(key=lambda limit: limit["kind"] not in ORDERS)  # the motion's are soonest known
    for limit in limits:
        yield from MEASURES[limit["kind"]](cam, limit)
    for move in cam.moves:
        segment = cam.spec["program"][move.index]
        for j, window in enumerate(segment.get("windows") or []):
            ends = (
                window["from_deg"] / segment["angle_deg"],
                window["to_deg"] / segment["angle_deg"],
            )
            yield from prescribed(cam, move, f"window_{j}", ends, window)
        for j, point in enumerate(segment.get("points") or []):
            at = point["angle_deg"] / segment["angle_deg"]
            yield from prescribed(cam, move, f"point_{j}", (at, at), point)


def prescribed(
    cam: Cam, move: PlacedSegment, place: str, ends: tuple[float, float], asked: dict[str, Any]
) -> Iterator[Reading]:
    """What a window or a point asks: both ends of each range, and the distance to each value."""
    for order, name in enumerate(("travel", "velocity", "acceleration", "jerk")):
        suffix = "" if order == 0 else "_per_s" if order == 1 else f"_per_s{order}"
        question = asked.get(f"{name}_{cam.unit}{suffix}")
        if question is None:
            continue
        rate = cam.omega**order * (np.sign(move.lift) if order == 0 else 1.0)
        start = move.level if order == 0 else 0.0

        def reached(s: list[np.ndarray], order: int = order, rate: float = rate,
                    start: float = start) -> np.ndarray:  # fmt: skip
            return rate * (s[order] - start)

        title = f"program_{move.index}_{place}_{name}"
        rounding = 1e-9 * abs(move.lift) * (cam.omega / move.beta) ** order
        rounding += cam.noise(order) * cam.omega**order
        if not isinstance(question, dict):
            allowance = asked.get(f"tolerance_{cam.unit}", 0.0) if order == 0 else 0.0
            value = cam.largest_within(
                move.index, *ends, lambda s, q=question, f=reached: np.abs(f(s) - q)
            )
            yield Reading(title, value, allowance, 10.0 * rounding, lambda value: None)
            continue
        for end, sign in (("min", -1.0), ("max", 1.0)):
            if question.get(end) is None:
                continue
            value = cam.largest_within(
                move.index, *ends, lambda s, sign=sign, f=reached: sign * f(s)
            )
            yield Reading(f"{title}_{end}", value, sign * question[end], rounding,
                          lambda value, sign=sign: sign * value)  # fmt: skip


def label(name: str, more: str) -> str:
    return f"{name}_{more}" if more else name


def pressure_angle(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    for index, name in enumerate(cam.names()):
        for kind in ("rise", "return", "dwell"):
            bound = limit.get(f"{kind}_deg")
            if bound is None or not any(move.kind == kind for move in cam.moves):
                continue
            value = cam.largest(
                lambda s, index=index: np.abs(cam.path(index, s).pressure_angle), (kind,)
            )
            yield Reading(label(f"pressure_angle_{kind}", name), value, bound, 3e-8)


def bends(cam: Cam, side: int, index: int, up: bool) -> float:
    """Largest σκ (up) or −σκ of a path; infinite at a corner that turns that way."""
    sign = side if up else -side
    value = cam.largest(lambda s: sign * cam.path(index, s).curvature)
    for number, (slow, fast, scale, _) in enumerate(cam.joints(1)):
        if abs(fast - slow) > 1e-7 * scale:
            (left, i, x), (right, k, y) = (
                cam.grids[number],
                cam.grids[(number + 1) % len(cam.grids)],
            )
            before, after = cam.s(left, i, x[-1:]), cam.s(right, k, y[:1])
            turn = np.conj(cam.path(index, before).p1) * cam.path(index, after).p1
            if -sign * float(np.imag(turn)[0]) > 0.0:
                return inf
    return value


def profile_radius(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    least = limit.get("min_mm", 0.0)
    if "roller_radius_mm" not in cam.spec["follower"]:
        base = cam.size["base_radius_mm"]
        value = cam.largest(lambda s: -Face(cam.spec, cam.size, s).radius)
        jump, noise = cam.jump(1)
        if jump > noise * 50.0:
            value = inf
        slack = 1e-11 * base + 10.0 * cam.noise(2) * cam.per_unit
        yield Reading("profile_radius", value, -least, slack, lambda value: -value, base)
        return
    for flank in sides(cam.spec):
        smallest = flank.distance + least
        if smallest <= 0.0:
            continue
        value = bends(cam, flank.side, cam.names().index(flank.path), True)
        distance = flank.distance
        yield Reading(
            label("profile_radius", flank.name), value, 1.0 / smallest, 1e-8 / smallest,
            lambda k, distance=distance: 1.0 / k - distance if k > 0.0 else None,
            1e-5 * distance,  # of which the radius is the rest
        )  # fmt: skip


def cutter_radius(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    for flank in sides(cam.spec):
        radius = limit["radius_mm"] - flank.distance
        if radius > 0.0:
            value = bends(cam, flank.side, cam.names().index(flank.path), False)
            distance = flank.distance
            yield Reading(
                label("cutter_radius", flank.name), value, 1.0 / radius, 1e-8 / radius,
                lambda k, distance=distance: 1.0 / k + distance if k > 0.0 else None,
            )  # fmt: skip


def outer_radius(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    # a point of the profile itself: the traced point moved along its normal, rim and all
    for index, name in enumerate(cam.names()):
        value = 0.0
        for flank in [f for f in sides(cam.spec) if f.path == name] or [None]:

            def radius(s: list[np.ndarray], flank: Any = flank, index: int = index) -> np.ndarray:
                path = cam.path(index, s)
                if flank is None:
                    return np.abs(path.w)
                return np.abs(path.w - (flank.side * flank.distance - flank.rim) * path.normal)

            value = max(value, cam.largest(radius))
        bound = limit["max_mm"]
        yield Reading(label("outer_radius", name), value, bound, 1e-8 * bound)


def counter_base_radius(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    for flank in sides(cam.spec)[1:]:
        value = cam.largest(lambda s: -np.abs(cam.path(1, s).w))
        yield Reading(
            "counter_base_radius", value + flank.distance, -limit.get("min_mm", 0.0),
            1e-8 * (flank.distance + limit.get("min_mm", 0.0)), lambda value: -value,
        )  # fmt: skip


def face_width(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    slack = 1e-12 * cam.size["base_radius_mm"] + 1e-10 * cam.per_unit * max(
        abs(m.lift) / m.beta for m in cam.moves
    )
    jump, noise = cam.jump(0)
    left = cam.largest(lambda s: -Face(cam.spec, cam.size, s).place)
    right = cam.largest(lambda s: Face(cam.spec, cam.size, s).place)
    if jump > noise * 50.0:
        left = right = inf
    wanted = {"face_width": (2.0 * max(left, right), limit.get("width_mm")),
              "face_left": (left, limit.get("left_mm")),
              "face_right": (right, limit.get("right_mm")),
              "face_far": (right, limit.get("far_mm"))}  # fmt: skip
    for name, (value, bound) in wanted.items():
        if bound is not None:
            yield Reading(name, value, bound, 2.0 * slack)
    if limit.get("near_mm") is not None:
        yield Reading("face_near", left, -limit["near_mm"], 2.0 * slack, lambda value: -value)


def derivative(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    order = ORDERS[limit["kind"]]
    rate = cam.omega**order
    bound = next(value for key, value in limit.items() if key.startswith("max_") and value)
    value = peak(cam, order)
    yield Reading(limit["kind"], value * rate, bound, 1e-9 * bound + cam.noise(order) * rate)


def residual_vibration(cam: Cam, limit: dict[str, Any]) -> Iterable[Reading]:
    levels = [level for m in cam.moves for level in (m.level, m.level + m.lift)]
    stroke = max(levels) - min(levels)
    question = next(limit[key] for key in ("max_mm", "max_deg") if limit.get(key) is not None)
    value = max(amplitudes(cam.moves, cam.omega, limit), default=0.0)
    yield Reading("residual_vibration", value, question or 1e-9 * stroke, 2e-10 * stroke)


def peak(cam: Cam, order: int) -> float:
    """Largest |s^(n)| per radian; infinite where a lower one jumps."""
    for below in range(order):
        jump, noise = cam.jump(below)
        if jump > 50.0 * noise:
            return inf
    if order not in cam.peaks:
        cam.peaks[order] = cam.largest(lambda s: np.abs(s[order]))
    return cam.peaks[order]


MEASURES: dict[str, Callable[[Cam, dict[str, Any]], Iterable[Reading]]] = {
    "pressure_angle": pressure_angle,
    "profile_radius": profile_radius,
    "cutter_radius": cutter_radius,
    "outer_radius": outer_radius,
    "counter_base_radius": counter_base_radius,
    "face_width": face_width,
    "velocity": derivative,
    "acceleration": derivative,
    "jerk": derivative,
    "residual_vibration": residual_vibration,
}


# -- objectives ----------------------------------------------------------------------------------


def objective(cam: Cam, kind: str) -> float:
    """Value of an objective in the wire's unit."""
    if kind == "base_radius":
        return cam.size["base_radius_mm"]
    if kind == "peak_pressure_angle":
        return max(
            cam.largest(lambda s, i=i: np.abs(cam.path(i, s).pressure_angle), ("rise", "return"))
            for i in range(len(cam.names()))
        )
    order = ORDERS[kind.split("_")[1]]
    if kind.startswith("peak_"):
        return peak(cam, order) * cam.omega**order
    for below in range(order):
        jump, noise = cam.jump(below)
        if jump > 50.0 * noise:
            return inf
    nodes, weights = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for move, piece, x in cam.grids:
        # a sinusoid of a few waves needs several intervals of 24 nodes, a polynomial one
        cuts = np.linspace(x[0], x[-1], 5)
        for a, b in pairwise(cuts):
            values = move.at(piece, 0.5 * (a + b) + 0.5 * (b - a) * nodes, order)
            total += 0.5 * (b - a) * move.beta * float(weights @ values**2)
    return float(np.sqrt(total / (2.0 * pi))) * cam.omega**order


def objectives(spec: dict[str, Any]) -> list[str]:
    question = spec.get("objective") or {"kind": "base_radius"}
    return [one["kind"] for one in (question if isinstance(question, list) else [question])]


# -- the whole verdict ---------------------------------------------------------------------------


def rebuilt(spec: dict[str, Any], design: dict[str, Any]) -> Cam:
    """The cam of a design."""
    splines = {i: m["spline"] for i, m in enumerate(design["motion"]) if m["spline"] is not None}
    cam = Cam(spec, segments(spec, splines), design["dimensions"])
    cam.look_at([extreme["angle_deg"] for extreme in design["extremes"]])
    return cam


def numbered(spec: dict[str, Any], design: dict[str, Any]) -> dict[str, Any]:
    """The spec with the numbers in place that it leaves free."""
    program, follower = [dict(segment) for segment in spec["program"]], dict(spec["follower"])
    for field, value in (design.get("free_parameters") or {}).items():
        *_, index, name = field.strip("/").split("/")
        (follower if index == "follower" else program[int(index)])[name] = value
    return spec | {"program": program, "follower": follower}


def verify(spec: dict[str, Any], design: dict[str, Any]) -> list[str]:
    """What a design says and does not keep; empty where it keeps everything."""
    if not design["motion"]:
        reported = design["status"] in ("infeasible", "unsolved") and design["conflict"] is not None
        return [] if reported else ["no motion, and no conflict named"]
    question, spec = spec, numbered(spec, design)
    cam = rebuilt(spec, design)
    certified = design["status"] in ("optimal", "feasible")
    found = [] if certified == design["certificate"]["certified"] else ["status ≠ certificate"]
    if certified or _regular(design):
        found += _claims(cam, design, certified)
    if certified:
        found += [*_motion(cam, spec, design), *_size(cam, spec, design)]
        found += _chosen(question, spec)
        found += _proofs(cam, spec, design)
    elif design["conflict"] is None or not design["conflict"]["limits"]:
        found.append("no cam, and no reason")
    return found


def _regular(design: dict[str, Any]) -> bool:
    """Whether a refused cam is one at all: what is measured on others means little."""
    basic = ("reach", "prime_circle_angle", "base_radius_positive", "motion", "displacement_join")
    return all(e["holds"] for e in design["extremes"] if e["limit"].startswith(basic))


def _claims(cam: Cam, design: dict[str, Any], certified: bool) -> Iterable[str]:
    """Every limit is there, its value is what is measured here, and it holds if it is said to."""
    left, measured = list(design["extremes"]), list(readings(cam))
    if certified and not all(extreme["holds"] for extreme in left):
        yield "certified, though a limit is said not to hold"
    undercut = any(own.broken for own in measured if own.name.startswith("profile_radius"))
    for own in measured:
        if own.name.startswith("outer_radius") and undercut and not certified:
            continue  # the profile has loops, which have no outermost point of use
        wire = own.wire(own.bound)
        mine = [
            e for e in left
            if e["limit"] == own.name and (wire is None or e["bound"] is None or close(
                *((e["bound"], wire) if own.name.startswith("profile")
                  else (abs(e["bound"]), abs(wire))), 1e-9))
        ]  # fmt: skip
        if not mine:
            yield f"{own.name} ≤ {wire}: not in the certificate"
            continue
        said = mine[0]
        left.remove(said)
        if said["holds"] and own.broken:
            yield f"{own.name}: {own.value} breaks {own.bound}, certified as {said['value']}"
        unproven = said["value"] is None  # on a cam that was refused: no value is claimed for it
        if not said["holds"] and not unproven and own.kept_clearly:
            yield f"{own.name}: refused at {said['value']}, but {own.value} keeps {own.bound}"
        if said["value"] is not None and isfinite(own.value):
            value = own.wire(own.value)
            yield from _same_value(own, said["value"], value)
    if any(own.broken for own in measured) and certified:
        yield "certified, though broken"


def _same_value(own: Reading, said: float, value: float | None) -> Iterable[str]:
    """The reported extreme is the one found here."""
    if value is None or own.name.startswith(("profile_radius", "cutter_radius")):
        # radii near flat ends are large: compare what the limit is about, the curvature
        low, high = sorted((0.0 if value is None else value, said))
        scale = max(abs(own.wire(own.bound) or 0.0), 1e-3, own.scale)
        if value is not None and high - low > 1e-5 * max(abs(low), abs(high), scale):
            yield f"{own.name}: said {said}, measured {value}"
        return
    if abs(abs(said) - abs(value)) > 1e-6 * max(abs(value), abs(said)) + 10.0 * own.slack:
        yield f"{own.name}: said {said}, measured {value}"


def close(a: float, b: float, tolerance: float) -> bool:
    return abs(a - b) <= tolerance * max(abs(a), abs(b), 1e-300)


def _motion(cam: Cam, spec: dict[str, Any], design: dict[str, Any]) -> Iterable[str]:
    """The program is followed, joints are as smooth as promised, nothing runs backwards."""
    stroke = max(m.level + max(m.lift, 0.0) for m in cam.moves)
    for move, reported in zip(
        cam.moves, [design["motion"][m.index] for m in cam.moves], strict=True
    ):
        unit = f"s_start_{cam.unit}"
        if not abs(reported[unit] - move.level) <= 1e-12 * stroke:
            yield f"segment {move.index} starts at {reported[unit]}, not {move.level}"
        if move.kind == "dwell":
            continue
        ends = move.pieces[0][2](np.zeros(1), 0)[0], move.pieces[-1][2](np.ones(1), 0)[0]
        if abs(ends[0]) > 1e-9 or abs(ends[1] - 1.0) > 1e-9:
            yield f"segment {move.index}: the law runs from {ends[0]} to {ends[1]}"
        if move.free is not None and not move.free.get("overshoot", False):
            back = _backwards(move)
            if back > 2e-9:
                yield f"segment {move.index}: runs backwards by {back} of its lift"
    for order in range(5):
        for number, (before, after, scale, rounding) in enumerate(cam.joints(order)):
            left, right = cam.grids[number][0], cam.grids[(number + 1) % len(cam.grids)][0]
            promised = [m.free.get("smoothness", 2) for m in (left, right) if m.free is not None]
            least = max(min(promised, default=0), spec.get("continuity") or 0)
            if order > least:
                continue
            if abs(after - before) > 4e-9 * scale + 10.0 * rounding:
                yield f"derivative {order} jumps by {after - before} behind segment {left.index}"


def _chosen(question: dict[str, Any], spec: dict[str, Any]) -> Iterable[str]:
    """What was left free lies in its range, and the turn closes."""
    arm = question["follower"].get("arm_mm")
    if isinstance(arm, dict) and not _within(spec["follower"]["arm_mm"], arm, 0.0):
        yield f"arm_mm = {spec['follower']['arm_mm']}, asked {arm}"
    for i, (was, now) in enumerate(zip(question["program"], spec["program"], strict=True)):
        for key in ("angle_deg", "lift_mm"):
            if isinstance(was.get(key), dict) and not _within(now[key], was[key], 1e-9):
                yield f"segment {i}: {key} = {now[key]}, asked {was[key]}"
    turn = sum(segment["angle_deg"] for segment in spec["program"])
    if abs(turn - 360.0) > 2e-6:
        yield f"the angles sum to {turn}°"


def _backwards(move: PlacedSegment) -> float:
    """Farthest travel backwards on a segment, over its lift."""
    g = np.concatenate([curve(np.linspace(a, b, 60), 0) for a, b, curve in move.pieces])
    return float(np.max(np.maximum.accumulate(g) - g))


def _within(value: float, question: Any, slack: float) -> bool:
    if question is None:
        return True
    if isinstance(question, dict):
        low, high = question.get("min"), question.get("max")
        return (low is None or value >= low - slack) and (high is None or value <= high + slack)
    return abs(value - question) <= slack


def _size(cam: Cam, spec: dict[str, Any], design: dict[str, Any]) -> Iterable[str]:
    """Dimensions agree with each other and lie in their ranges."""
    size, follower = design["dimensions"], spec["follower"]
    prime = size["base_radius_mm"] + base_gap(spec)
    slack = 1e-11 * max(prime, size["base_radius_mm"])
    if not (size["base_radius_mm"] > 0.0 and prime > 0.0):
        yield f"no positive radius: base {size['base_radius_mm']}, prime {prime}"
    question: dict[str, Any] = {"base_radius_mm": spec.get("base_radius_mm")}
    question |= {key: follower.get(key) for key in ("offset_mm", "centre_distance_mm")}
    question["initial_angle_deg"] = follower.get("initial_angle_deg")
    for key, wanted in question.items():
        if key in size and not _within(size[key], wanted, slack + 1e-10 * abs(size[key])):
            yield f"{key} = {size[key]}, asked {wanted}"
    if "s0_mm" in size:
        if not size["s0_mm"] > 0.0:
            yield f"the roller is not above the axis: s0 = {size['s0_mm']}"
        if not close(float(np.hypot(size["offset_mm"], size["s0_mm"])), prime, 1e-9):
            yield "e² + s0² ≠ Rp²"
    if "arm_mm" in follower:
        arm, d = follower["arm_mm"], size["centre_distance_mm"]
        end = d - arm * np.exp(1j * size["initial_angle_deg"] * RAD)
        if not abs(abs(end) - prime) <= 1e-9 * (arm + d):
            yield f"the arm's triangle has the side {abs(end)}, not {prime}"
        swing = max(m.level + max(m.lift, 0.0) for m in cam.moves)
        if not 0.0 < size["initial_angle_deg"] < 180.0 - swing:
            yield "the arm passes the line of centres"


ASSUMED_GAP = 0.25 / 1.25  # of the rms jerk where no objective is named


def _proofs(cam: Cam, spec: dict[str, Any], design: dict[str, Any]) -> Iterable[str]:
    """Objective values as reported; bounds below them; "optimal" only within the tolerance."""
    proofs = [design["certificate"], *design["certificate"]["other_objectives"]]
    kinds, allowed = objectives(spec), spec.get("tolerance", 1e-3)
    if spec.get("objective") is None and design["assumptions"]:
        kinds = [*kinds, "rms_jerk"]  # within a quarter of the least
    if len(proofs) != len(kinds):
        yield f"{len(kinds)} objectives, {len(proofs)} proofs"
        return
    for kind, proof in zip(kinds, proofs, strict=True):
        value, reported, lower = objective(cam, kind), proof["value"], proof["lower_bound"]
        if not isfinite(value):
            if reported is not None:
                yield f"{kind}: said {reported}, but it is infinite"
            continue
        room = 1e-6 * max(abs(value), 0.0 if reported is None else abs(reported))
        if kind == "base_radius":  # the prime radius less the roller's
            room += 1e-15 * (value + base_gap(spec))
        if reported is None or not abs(reported - value) <= room:
            yield f"{kind}: said {reported}, measured {value}"
            continue
        if lower is not None and lower > reported * (1.0 + 1e-12):
            yield f"{kind}: bound {lower} above the value {reported}"
        if design["status"] == "optimal":
            gap = proof["gap"]
            most = max(allowed, ASSUMED_GAP) if len(kinds) > len(objectives(spec)) else allowed
            if gap is None or lower is None or gap > (most if kind == "rms_jerk" else allowed):
                yield f"{kind}: optimal with the gap {gap}"
            elif not abs((reported - lower) - gap * abs(reported)) <= 1e-9 * abs(reported):
                yield f"{kind}: the gap {gap} is not that of {reported} and {lower}"
