"""What the tests know of every follower family: a new one needs an entry in each table here.

SAMPLES: given cams, at sizes where nothing is special. LIFTS: how far they move. BODIES: where the
follower's body is, from its dimensions alone, by lines, circles and an angle at a pivot. Nothing of
the bodies is asked of the follower's class but the names and values of its dimensions, so that what
is compared with them shares no formula with them; all in the machine frame of a ccw cam.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.spec.design_spec import DesignSpec

SLIDE = {"kind": "translating_roller", "roller_radius_mm": 9.3, "offset_mm": 7.1}
ARM = {"kind": "oscillating_roller", "arm_mm": 81.3, "roller_radius_mm": 17.9}
FACE = {"kind": "oscillating_flat_face", "face_offset_mm": 4.3}
RING = {"closure": {"kind": "force", "contact": "inside"}}
GROOVE = {"closure": {"kind": "groove", "clearance_mm": 0.21}}
PAIR = {
    "closure": {
        "kind": "conjugate", "roller_radius_mm": 6.7, "offset_mm": -2.9, "distance_mm": 148.3,
    }
}  # fmt: skip
LEVER = {
    "closure": {"kind": "conjugate", "roller_radius_mm": 8.3, "arm_mm": 66.1, "angle_deg": 118.7}
}
# family: followers and their base radii
SAMPLES: dict[str, list[tuple[dict[str, Any], float]]] = {
    "translating_roller": [
        (SLIDE, 41.9),
        (SLIDE | {"roller_radius_mm": 0.0, "offset_mm": -3.7}, 52.3),
        (SLIDE | RING, 74.9),
        (SLIDE | GROOVE, 58.7),
        (SLIDE | PAIR, 44.3),
    ],
    "translating_flat_face": [
        ({"kind": "translating_flat_face"}, 97.7),
        ({"kind": "translating_flat_face", "tilt_deg": -6.7, "offset_mm": 3.1}, 91.3),
    ],
    "oscillating_roller": [
        (ARM | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 71.7),
        (ARM | {"centre_distance_mm": 93.1, "sense": "same", "pivot_direction_deg": -61.0}, 64.3),
        (ARM | RING | {"centre_distance_mm": 111.7, "pivot_direction_deg": 17.0}, 97.9),
        (ARM | RING | {"centre_distance_mm": 119.3, "sense": "same"}, 101.3),
        (ARM | GROOVE | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 62.9),
        (ARM | GROOVE | {"centre_distance_mm": 109.1, "sense": "same"}, 66.7),
        (ARM | LEVER | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 54.1),
        (ARM | LEVER | {"centre_distance_mm": 103.7, "sense": "same"}, 49.9),
    ],
    "oscillating_flat_face": [
        (FACE | {"centre_distance_mm": 103.9, "pivot_direction_deg": -37.0}, 63.7),
        (FACE | {"centre_distance_mm": 131.1, "sense": "same", "face_offset_mm": -5.9}, 97.3),
    ],
}  # fmt: skip
LIFTS = {
    "translating_roller": 19.7, "translating_flat_face": 19.7,
    "oscillating_roller": 23.3, "oscillating_flat_face": 13.7,
}  # fmt: skip
"""In the unit of the family's travel: faces on pivots are undercut by larger swings."""
CASES = [(kind, i) for kind, samples in SAMPLES.items() for i in range(len(samples))]


def spec(
    kind: str, sample: int = 0, laws: tuple[str, str] = ("polynomial_4_5_6_7", "cycloidal"),
    **changes: Any,
) -> DesignSpec:  # fmt: skip
    """A given cam of a family, with its laws up and down."""
    follower, base = SAMPLES[kind][sample]
    unit = "mm" if kind.startswith("translating") else "deg"
    lift = {f"lift_{unit}": LIFTS[kind]}
    body = {
        "name": f"{kind} {sample}",
        "speed_rpm": 137.0,
        "program": [
            {"kind": "rise", "angle_deg": 97.3, "law": {"kind": laws[0]}} | lift,
            {"kind": "dwell", "angle_deg": 41.2},
            {"kind": "return", "angle_deg": 118.9, "law": {"kind": laws[1]}} | lift,
            {"kind": "dwell", "angle_deg": 102.6},
        ],
        "follower": follower,
        "base_radius_mm": base,
        "limits": [
            {"kind": "velocity", f"max_{unit}_per_s": 1e4},
            {"kind": "acceleration", f"max_{unit}_per_s2": 1e6},
            {"kind": "jerk", f"max_{unit}_per_s3": 1e8},
        ],
    }
    return DesignSpec.model_validate(body | changes)


# -- bodies ------------------------------------------------------------------------------------

Points = np.ndarray  # (2, n)


@dataclass(frozen=True)
class Body:
    """One roller or face, at displacements s (n,) [mm].

    Attributes:
        place: (2, n) the roller's centre, or a point of the face. velocity: (2, n) of a point
            fixed to the body at given places, per unit of lift. outward: (2, n) a face's unit
            normal, away from the cam; None of a roller. radius: of the roller [mm].
    """

    place: Points
    pivot: Points | None
    turn: float  # +1 where a lift turns the body counter-clockwise about its pivot
    radius: float
    outward: Points | None = None

    def velocity(self, at: Points) -> Points:
        if self.pivot is None:
            return np.stack([0.0 * at[0], 1.0 + 0.0 * at[0]])
        x, y = at - self.pivot[:, None]
        return self.turn * np.stack([-y, x])

    def apart(self, points: Points) -> np.ndarray:
        """How far each of (2, m) points lies outside the body: (n, m) [mm]."""
        if self.outward is None:
            away = points[:, None, :] - self.place[:, :, None]
            return np.hypot(*away) - self.radius
        reach = np.sum(self.outward * self.place, axis=0)
        return reach[:, None] - self.outward.T @ points


def heading(angle: np.ndarray) -> Points:
    return np.stack([np.cos(angle), np.sin(angle)])


def bodies(question: DesignSpec, reported: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    """Every body of a follower by the path that it draws; ``told``: its dimensions."""
    given = question.follower.model_dump()
    return BODIES[given["kind"]](given, reported, s)


def slide(given: dict, reported: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    e, prime = given["offset_mm"], reported["prime_radius_mm"]
    height = np.sqrt(prime**2 - e**2) + s
    main = Body(np.stack([e + 0.0 * s, height]), None, 0.0, given["roller_radius_mm"])
    own = given["closure"]
    if own["kind"] != "conjugate":
        return {"": main}
    place = np.stack([own["offset_mm"] + 0.0 * s, height - own["distance_mm"]])
    return {"main": main, "counter": Body(place, None, 0.0, own["roller_radius_mm"])}


def face(given: dict, reported: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    tilt = np.radians(given.get("tilt_deg", 0.0))
    # at the distance Rb from the axis when lowest, lifted along y
    normal = np.stack([-np.sin(tilt) + 0.0 * s, np.cos(tilt) + 0.0 * s])
    return {"": Body(reported["base_radius_mm"] * normal + [0.0 * s, s], None, 0.0, 0.0, normal)}


def lever(given: dict, reported: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    l, d, prime = given["arm_mm"], given["centre_distance_mm"], reported["prime_radius_mm"]
    direction = np.radians(given["pivot_direction_deg"])
    pivot = d * heading(np.array(direction))
    turn = -1.0 if given["sense"] == "opposite" else 1.0
    start = np.arccos((d * d + l * l - prime**2) / (2.0 * d * l))
    angle = start + s / l  # from the line to the axis

    def end(length: float, away: np.ndarray) -> Points:
        return pivot[:, None] + length * heading(direction + np.pi + away)

    main = Body(end(l, turn * angle), pivot, turn, given["roller_radius_mm"])
    own = given["closure"]
    if own["kind"] != "conjugate":
        return {"": main}
    beyond = turn * (angle - np.radians(own["angle_deg"]))
    counter = Body(end(own["arm_mm"], beyond), pivot, turn, own["roller_radius_mm"])
    return {"main": main, "counter": counter}


def hinge(given: dict, reported: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    d, f = given["centre_distance_mm"], given["face_offset_mm"]
    direction = np.radians(given["pivot_direction_deg"])
    turn = -1.0 if given["sense"] == "opposite" else 1.0
    start = np.arcsin((reported["base_radius_mm"] + f) / d)
    along = direction + np.pi + turn * (start + s / d)
    outward = heading(along + 0.5 * np.pi * turn)
    pivot = d * heading(np.array(direction))
    return {"": Body(pivot[:, None] - f * outward, pivot, turn, 0.0, outward)}


BODIES = {
    "translating_roller": slide,
    "translating_flat_face": face,
    "oscillating_roller": lever,
    "oscillating_flat_face": hinge,
}
