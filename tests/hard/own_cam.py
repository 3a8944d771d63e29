"""A cam rebuilt from wire values alone, in complex numbers. Nothing of the product is imported.

The traced point is w(θ) in the machine frame of a ccw cam (the axis at 0, y up) and p = w e^(−iθ)
on the cam, so with D = d/dθ: p' = (w' − iw) e^(−iθ), p'' = (w'' − 2iw' − w) e^(−iθ). The curve runs
clockwise round the axis: its outward normal is i p', its curvature, convex positive, is
−Im(conj(p') p'')/|p'|³.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from tests.hard.own_laws import Piece, named, spline

STILL: list[Piece] = [(0.0, 1.0, lambda x, n: 0.0 * x)]
LINE: list[Piece] = [(0.0, 1.0, lambda x, n: [x, 1.0 + 0.0 * x, 0.0 * x][min(n, 2)])]
RAD = pi / 180.0


@dataclass(frozen=True)
class PlacedSegment:
    """A segment with an extent: angles in rad, levels in the wire's unit (mm or deg)."""

    index: int
    kind: str
    start: float
    beta: float
    level: float
    lift: float
    pieces: list[Piece]
    free: dict[str, Any] | None
    noise: tuple[float, ...]  # rounding of the 0th to 4th derivative of g

    def at(self, piece: int, x: np.ndarray, n: int) -> np.ndarray:
        """n-th derivative per radian at x in [0, 1] of the segment, by one of its pieces."""
        g = self.pieces[piece][2](x, n)
        return (self.level if n == 0 else 0.0) + self.lift / self.beta**n * g


@dataclass(frozen=True)
class Path:
    """A traced point and its derivatives, and the unit vector that the cam drives it along."""

    name: str
    w: np.ndarray
    w1: np.ndarray
    w2: np.ndarray
    g: np.ndarray
    face: np.ndarray | None = None  # outward normal of a flat face

    @property
    def p1(self) -> np.ndarray:
        """p' seen in the machine frame."""
        return self.w1 - 1j * self.w

    @property
    def curvature(self) -> np.ndarray:
        p2 = self.w2 - 2j * self.w1 - self.w
        return -np.imag(np.conj(self.p1) * p2) / np.abs(self.p1) ** 3

    @property
    def normal(self) -> np.ndarray:
        return 1j * self.p1 / np.abs(self.p1) if self.face is None else self.face

    @property
    def pressure_angle(self) -> np.ndarray:
        """Signed, in degrees."""
        return np.angle(self.normal / self.g) / RAD


def gain(segment: dict[str, Any], unit: str, speed_rpm: float) -> float:
    """Displacement gained over a segment, in the wire's unit."""
    sign = {"rise": 1.0, "return": -1.0, "dwell": 0.0, "constant_velocity": 1.0}
    velocity = segment.get(f"velocity_{unit}_per_s")
    if velocity is not None:  # over the time that the segment takes
        return float(velocity * segment["angle_deg"] / (6.0 * speed_rpm))
    return sign[segment["kind"]] * (segment.get(f"lift_{unit}") or 0.0)


def lowest(program: Sequence[dict[str, Any]], unit: str, speed_rpm: float) -> list[float]:
    """Levels at the ends of the segments, from the lowest one."""
    levels = [0.0]
    for segment in program:
        levels.append(levels[-1] + gain(segment, unit, speed_rpm))
    return [level - min(levels) for level in levels]


def unit_of(spec: dict[str, Any]) -> str:
    return "deg" if spec["follower"]["kind"].startswith("oscillating") else "mm"


def segments(spec: dict[str, Any], splines: dict[int, Any]) -> list[PlacedSegment]:
    """The motion of a spec.

    Args:
        splines: pieces, or a B-spline from the wire, of every segment whose law is free.
    """
    program, unit = spec["program"], unit_of(spec)
    turn = sum(segment["angle_deg"] for segment in program)
    levels, angle, found = lowest(program, unit, spec.get("speed_rpm", 60.0)), 0.0, []
    for i, segment in enumerate(program):
        beta = segment["angle_deg"] / turn * 2.0 * pi
        law, free = segment.get("law") or {"kind": "spline"}, None
        noise = tuple(1e-13 * 60.0**n for n in range(5))
        lift, kind = levels[i + 1] - levels[i], segment["kind"]
        if kind == "dwell":
            pieces = STILL
        elif kind == "constant_velocity":
            pieces, kind = LINE, "rise" if lift > 0.0 else "return"
        elif law["kind"] == "spline":
            free, given = law, splines[i]
            pieces = given
            if isinstance(given, dict):
                pieces = spline(given)
                gap, p = float(np.min(np.diff(given["knots"]))), given["degree"]
                size = float(np.max(np.abs(given["coefficients"])))
                noise = tuple(4e-16 * size * (2.0 * p / gap) ** n for n in range(5))
        else:
            pieces = named(law, segment["kind"])
            narrow = min(b - a for a, b, _ in pieces)
            noise = tuple(1e-13 * max(60.0, 8.0 / narrow) ** n for n in range(5))
        if beta > 0.0:
            found.append(PlacedSegment(i, kind, angle, beta, levels[i], lift, pieces, free, noise))
        angle += beta
    return found


# -- the follower --------------------------------------------------------------------------------


def paths(spec: dict[str, Any], size: dict[str, float], s: Sequence[np.ndarray]) -> list[Path]:
    """The traced points at s, s', s'' [mm or deg], the first one the main one."""
    follower = spec["follower"]
    closure = follower.get("closure") or {"kind": "force"}
    pair = closure["kind"] == "conjugate"
    first = "main" if pair else ""
    one = np.ones_like(s[0], dtype=complex)
    if follower["kind"] == "translating_roller":
        w = size["offset_mm"] + 1j * (size["s0_mm"] + s[0])
        found = [Path(first, w, 1j * s[1], 1j * s[2], 1j * one)]
        if pair:
            below = closure.get("offset_mm", 0.0) + 1j * (
                size["s0_mm"] + s[0] - size["counter_distance_mm"]
            )
            found.append(Path("counter", below, 1j * s[1], 1j * s[2], -1j * one))
        return found
    if follower["kind"] == "oscillating_roller":
        sigma = {"opposite": 1.0, "same": -1.0}[follower.get("sense", "opposite")]
        gamma = follower.get("pivot_direction_deg", 0.0) * RAD
        pivot = size["centre_distance_mm"] * np.exp(1j * gamma)
        f0, f1, f2 = (RAD * value for value in s[:3])

        def arm(name: str, length: float, turn: float, angle: np.ndarray) -> Path:
            # the arm at `angle` from the line to the axis; turn: how it swings as φ grows
            a = length * np.exp(1j * (gamma + pi + turn * angle))
            drive = 1j * turn * a / length
            return drive, a, name

        psi = size["initial_angle_deg"] * RAD + f0
        made = [arm(first, follower["arm_mm"], -sigma, psi)]
        swings = [-sigma]
        if pair:
            other = size["counter_angle_deg"] * RAD - psi
            made.append(arm("counter", closure["arm_mm"], sigma, other))
            swings.append(-sigma)  # ψ2 falls as φ grows, measured the other way round
        found = []
        for (drive, a, name), sense in zip(made, swings, strict=True):
            k = 1j * sense
            found.append(Path(name, pivot + a, k * f1 * a, (k * f2 - f1**2) * a, drive))
        return found
    if follower["kind"].endswith("flat_face"):
        face = Face(spec, size, s)
        return [Path("", face.contact, 0.0 * one, 0.0 * one, face.drive, face.normal)]
    raise NotImplementedError(follower["kind"])


class Face:
    """A flat face at s, s', s'': where it touches, along which normal, how sharp the profile is.

    The profile is the envelope of the face: its support function h over the angle of the normal as
    seen from the cam, which turns by −turn per radian.
    """

    def __init__(
        self, spec: dict[str, Any], size: dict[str, float], s: Sequence[np.ndarray]
    ) -> None:
        follower, one = spec["follower"], np.ones_like(s[0], dtype=complex)
        if follower["kind"] == "translating_flat_face":
            tilt, c = follower.get("tilt_deg", 0.0) * RAD, follower.get("offset_mm", 0.0)
            cos, sin = np.cos(tilt), np.sin(tilt)
            h, h1, h2 = size["base_radius_mm"] + s[0] * cos, s[1] * cos, s[2] * cos
            self.normal, self.drive = 1j * np.exp(1j * tilt) * one, 1j * one
            along = np.exp(1j * tilt)
            self.radius = h + h2
            self.contact = h * self.normal + h1 * along
            # the slide's line x = c meets the face c sin τ + h above c cos τ's foot
            slide = c + 1j * (h + c * sin) / cos
            self.place = np.real((self.contact - slide) * np.conj(along))
            return
        sigma = {"opposite": 1.0, "same": -1.0}[follower.get("sense", "opposite")]
        gamma = follower.get("pivot_direction_deg", 0.0) * RAD
        f, d = follower.get("face_offset_mm", 0.0), size["centre_distance_mm"]
        f0, f1, f2 = (RAD * value for value in s[:3])
        psi = np.arcsin(np.clip((size["base_radius_mm"] + f) / d, -1.0, 1.0)) + f0
        u = np.exp(1j * (gamma + pi - sigma * psi))
        self.normal, pivot = -1j * sigma * u, d * np.exp(1j * gamma)
        foot = pivot - f * self.normal

        # at the contact point the face slides along itself over the cam
        def across(x: np.ndarray) -> np.ndarray:
            relative = -1j * sigma * f1 * (x - pivot) - 1j * x
            return np.real(relative * np.conj(self.normal))

        start = across(foot)
        self.place = -start / (across(foot + u) - start)
        self.contact = foot + self.place * u
        lever = self.contact - pivot
        self.drive = -1j * sigma * lever / np.abs(lever)
        turn, turn1 = 1.0 + sigma * f1, sigma * f2
        h = d * np.sin(psi) - f
        h1, h2 = d * np.cos(psi) * f1, d * (np.cos(psi) * f2 - np.sin(psi) * f1**2)
        self.radius = h + (h2 * turn - h1 * turn1) / turn**3


@dataclass(frozen=True)
class Side:
    """A flank at the distance D of a path; side +1 within it, −1 around it."""

    name: str
    path: str
    side: int
    distance: float
    rim: float = 0.0


def sides(spec: dict[str, Any]) -> list[Side]:
    """The flanks of a follower with a roller; () for a face."""
    follower = spec["follower"]
    if "roller_radius_mm" not in follower:
        return []
    roller, closure = follower["roller_radius_mm"], follower.get("closure") or {"kind": "force"}
    rim = closure.get("rim_mm", 0.0)
    if closure["kind"] == "groove":
        wide = roller + 0.5 * closure.get("clearance_mm", 0.0)
        return [Side("inner", "", 1, wide), Side("outer", "", -1, wide, rim)]
    if closure["kind"] == "conjugate":
        return [Side("main", "main", 1, roller),
                Side("counter", "counter", 1, closure["roller_radius_mm"])]  # fmt: skip
    return [Side("", "", -1 if closure.get("contact") == "inside" else 1, roller, rim)]


def base_gap(spec: dict[str, Any]) -> float:
    """Prime radius less base radius."""
    found = sides(spec)
    return found[0].side * found[0].distance if found else 0.0
