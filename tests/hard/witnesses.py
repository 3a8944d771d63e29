"""Cams of the verifier's own making, which a refusal or a lower bound must not contradict.

Free laws are replaced by laws that every free law may be (quintics that meet their neighbours,
and where both ends rest also constant jerk in turns, 3-4-5, cycloidal), free sizes by a grid.
Such a cam that clearly keeps every limit shows that something fits, and how good it can be.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import acos, asin, degrees, inf, sqrt
from typing import Any

import numpy as np

from tests.hard.own_cam import LINE, RAD, PlacedSegment, base_gap, lowest, segments, unit_of
from tests.hard.own_laws import Piece, backwards, hermite, named
from tests.hard.verifier import Cam, objective, objectives, readings

SIZES, OFFSETS = 14, 5
REST = {2: ["polynomial_3_4_5", "cycloidal", "constant jerk"], 3: ["polynomial_4_5_6_7"],
        4: ["polynomial_5_6_7_8_9"]}  # fmt: skip


def constant_jerk() -> list[Piece]:
    """Jerk ±32, switched at 1/4, 1/2 and 3/4: the least peak jerk between two rests."""
    up = lambda x, n: [16 / 3 * x**3, 16 * x**2, 32 * x, 32 + 0 * x, 0 * x][n]  # noqa: E731

    def down(x: np.ndarray, n: int) -> np.ndarray:
        t = x - 0.25
        s = 1 / 12 + t + 4 * t**2 - 16 / 3 * t**3
        return [s, 1 + 8 * t - 16 * t**2, 8 - 32 * t, -32 + 0 * t, 0 * t][n]

    first: list[Piece] = [(0.0, 0.25, up), (0.25, 0.5, down)]
    return first + backwards(first)


def law(name: str, kind: str) -> list[Piece]:
    return constant_jerk() if name == "constant jerk" else named({"kind": name}, kind)


def motions(spec: dict[str, Any]) -> Iterator[list[PlacedSegment]]:
    """The program with laws of our own in place of the free ones."""
    program = spec["program"]
    free = [
        i
        for i, segment in enumerate(program)
        if segment["kind"] in ("rise", "return")
        and (segment.get("law") or {"kind": "spline"})["kind"] == "spline"
    ]
    if not free:
        yield segments(spec, {})
        return
    placed = segments(spec, dict.fromkeys(free, LINE))
    position = {move.index: k for k, move in enumerate(placed)}
    choices = []
    for i in free:
        here = placed[position[i]]
        smooth = max(2, (program[i].get("law") or {}).get("smoothness", 2))  # C2 is C1 too
        ends = []
        for neighbour, x in ((placed[position[i] - 1], 1.0),
                             (placed[(position[i] + 1) % len(placed)], 0.0)):  # fmt: skip
            piece = -1 if x == 1.0 else 0
            known = neighbour.index not in free
            ends.append([float(neighbour.at(piece if piece == 0 else len(neighbour.pieces) - 1,
                                            np.array([x]), n)[0]) if known else 0.0
                         for n in range(1, 5)])  # fmt: skip
        rest = all(abs(v) <= 1e-9 * abs(here.lift) / here.beta ** (n + 1)
                   for end in ends for n, v in enumerate(end[:smooth]))  # fmt: skip
        if rest:
            choices.append([law(name, program[i]["kind"]) for name in REST[smooth]])
        elif smooth == 2:
            scale = [here.beta ** (n + 1) / here.lift for n in range(2)]
            left, right = ([float(v) * f for v, f in zip(end, scale, strict=False)] for end in ends)
            quintic = hermite((0.0, *left), (1.0, *right))
            if not program[i].get("law", {}).get("overshoot", False):
                slope = quintic[0][2](np.linspace(0.0, 1.0, 401), 1)
                if slope.min() < 0.0:
                    return
            choices.append([quintic])
        else:
            return
    for number in range(max(len(c) for c in choices)):
        chosen = [c[min(number, len(c) - 1)] for c in choices]
        yield segments(spec, dict(zip(free, chosen, strict=True)))


def grid(question: Any, low: float, high: float, count: int, log: bool) -> list[float]:
    """Values of a dimension, given or to be tried."""
    if isinstance(question, (int, float)):
        return [float(question)]
    question = question or {}
    low = low if question.get("min") is None else question["min"]
    high = high if question.get("max") is None else question["max"]
    if low > high:
        return []
    spaced = np.geomspace(max(low, 1e-12), max(high, 1e-12), count) if log else None
    return [float(v) for v in (spaced if log else np.linspace(low, high, count))]


def sizes(spec: dict[str, Any]) -> Iterator[dict[str, float]]:
    """Sizes to try."""
    follower, unit = spec["follower"], unit_of(spec)
    closure = follower.get("closure") or {}
    if closure.get("kind") == "conjugate":
        return
    levels = lowest(spec["program"], unit, spec.get("speed_rpm", 60.0))
    stroke = max(levels)
    if follower["kind"] == "oscillating_flat_face":
        f = follower.get("face_offset_mm", 0.0)
        for d in grid(follower["centre_distance_mm"], 10.0, 300.0, OFFSETS, False):
            for base in grid(spec.get("base_radius_mm"), 0.05 * d, 0.95 * d, SIZES, True):
                if abs(base + f) < d:
                    yield {"base_radius_mm": base, "centre_distance_mm": d}
        return
    if unit == "deg":
        stroke *= follower["arm_mm"] * np.pi / 180.0
    gap = base_gap(spec)
    # an open range ends at 1e-3 and 1e4 strokes; half a stroke to forty is where cams lie
    bases = grid(spec.get("base_radius_mm"), 0.2 * stroke, 20.0 * stroke, SIZES, True)
    if follower["kind"] == "translating_flat_face":
        yield from ({"base_radius_mm": base} for base in bases)
    elif follower["kind"] == "translating_roller":
        offsets = grid(follower.get("offset_mm"), -stroke, stroke, OFFSETS, False)
        for base, e in product(bases, offsets):
            if base + gap > abs(e):
                s0 = sqrt((base + gap) ** 2 - e * e)
                yield {"base_radius_mm": base, "offset_mm": e, "s0_mm": s0}
    else:
        arm = follower["arm_mm"]
        for base, d in product(bases, grid(follower.get("centre_distance_mm"), 0.6 * arm,
                                           3.0 * arm, OFFSETS, False)):  # fmt: skip
            cosine = (d * d + arm * arm - (base + gap) ** 2) / (2.0 * d * arm)
            if abs(cosine) < 1.0 and base + gap > 0.0 and not follower.get("initial_angle_deg"):
                yield {"base_radius_mm": base, "centre_distance_mm": d,
                       "initial_angle_deg": degrees(acos(cosine))}  # fmt: skip


@dataclass(frozen=True)
class Witness:
    """A cam that keeps every limit with room to spare."""

    cam: Cam
    value: float  # of the first objective


def sign(cam: Cam) -> float:
    return {"opposite": 1.0, "same": -1.0}[cam.spec["follower"].get("sense", "opposite")]


def stands(cam: Cam) -> bool:
    """Whether an arm stays between the two ends of its swing."""
    if cam.spec["follower"]["kind"] == "oscillating_flat_face":
        f, size = cam.spec["follower"].get("face_offset_mm", 0.0), cam.size
        first = degrees(asin((size["base_radius_mm"] + f) / size["centre_distance_mm"]))
        forward = min(float(1.0 + sign(cam) * np.min(sign(cam) * cam.sampled[0][1]) * RAD), 1.0)
        return forward > 1e-3 and first + max(m.level + max(m.lift, 0) for m in cam.moves) < 89.0
    if "initial_angle_deg" not in cam.size:
        return True
    return cam.size["initial_angle_deg"] + max(m.level + max(m.lift, 0) for m in cam.moves) < 179.9


def best(spec: dict[str, Any]) -> Witness | None:
    """The best of them; None where none keeps every limit by a thousandth."""
    found, first = None, objectives(spec)[0]
    for moves in motions(spec):
        roughly, closely = Cam(spec, moves, {}, dense=12), Cam(spec, moves, {})
        _ = roughly.sampled  # once for all sizes
        for size in sizes(spec):
            rough = roughly.sized(size)
            if size["base_radius_mm"] <= 0.0 or not stands(rough) or not keeps(rough, 1e-2):
                continue
            cam = closely.sized(size)
            value = objective(cam, first)
            if value < (inf if found is None else found.value) and keeps(cam, 1e-3):
                found = Witness(cam, value)
            if first == "base_radius":
                break
    return found


def keeps(cam: Cam, room: float) -> bool:
    return all(r.value < r.bound - room * abs(r.bound) - r.slack for r in readings(cam))


def below_least_peak(spec: dict[str, Any]) -> str:
    """Which limit no motion keeps: the mean velocity, 4 h/β² and 32 h/β³ between rests; else ""."""
    program, unit = spec["program"], unit_of(spec)
    omega = spec.get("speed_rpm", 60.0) * np.pi / 30.0
    caps = {one["kind"]: value for one in spec.get("limits", []) for key, value in one.items()
            if key.startswith(f"max_{unit}_per_s")}  # fmt: skip
    for i, move in enumerate(program):
        lift, angle = move.get(f"lift_{unit}"), move["angle_deg"]
        if move["kind"] == "dwell" or isinstance(lift, dict) or isinstance(angle, dict):
            continue
        around = (program[i - 1], program[(i + 1) % len(program)])
        rests = all(one["kind"] == "dwell" for one in around)
        for kind, order, least in (("velocity", 1, 1.0), ("acceleration", 2, 4.0),
                                   ("jerk", 3, 32.0)):  # fmt: skip
            needed = least * abs(lift or 0.0) * (omega / (angle * RAD)) ** order
            if kind in caps and (rests or order == 1) and caps[kind] < needed * (1.0 - 1e-8):
                return kind
    return ""


def contradictions(spec: dict[str, Any], design: dict[str, Any]) -> list[str]:
    """Refusals, bounds and cams that a cam of our own, or a least peak, shows to be wrong."""
    free = ("angle_deg", "lift_mm", "lift_deg")
    if any(isinstance(s.get(k), dict) for s in spec["program"] for k in free):
        return []
    impossible = below_least_peak(spec)
    if impossible and design["certificate"]["certified"]:
        return [f"certified, though no motion has so small a peak {impossible}"]
    if isinstance(spec["follower"].get("arm_mm"), dict):
        return []
    if spec.get("continuity"):
        return []
    refused = design["status"] == "infeasible"
    bound = design["certificate"]["lower_bound"]
    if not refused and (bound is None or "family" in design["certificate"]["bound_valid_for"]):
        return []
    witness = best(spec)
    if witness is None:
        return []
    if refused:
        return [f"refused, but there is a cam: {witness.cam.size}"]
    if bound > witness.value * (1.0 + 1e-7):
        return [f"bound {bound}, but a cam has {witness.value}: {witness.cam.size}"]
    return []
