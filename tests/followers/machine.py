"""Where a follower's body is, from its dimensions alone: lines, circles and an angle at a pivot.

Nothing here is asked of the follower's class but the names and values of its dimensions, so what
is compared with it shares no formula with it. All in the machine frame of a counter-clockwise cam.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from synthesis.spec import DesignSpec

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


def bodies(asked: DesignSpec, told: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    """Every body of a follower by the path that it draws; ``told``: its dimensions."""
    given = asked.follower.model_dump()
    make = {
        "translating_roller": slide, "translating_flat_face": face,
        "oscillating_roller": lever, "oscillating_flat_face": hinge,
    }  # fmt: skip
    return make[given["kind"]](given, told, s)


def slide(given: dict, told: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    e, prime = given["offset_mm"], told["prime_radius_mm"]
    height = np.sqrt(prime**2 - e**2) + s
    main = Body(np.stack([e + 0.0 * s, height]), None, 0.0, given["roller_radius_mm"])
    own = given["closure"]
    if own["kind"] != "conjugate":
        return {"": main}
    place = np.stack([own["offset_mm"] + 0.0 * s, height - own["distance_mm"]])
    return {"main": main, "counter": Body(place, None, 0.0, own["roller_radius_mm"])}


def face(given: dict, told: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    tilt = np.radians(given.get("tilt_deg", 0.0))
    # at the distance Rb from the axis when lowest, lifted along y
    normal = np.stack([-np.sin(tilt) + 0.0 * s, np.cos(tilt) + 0.0 * s])
    return {"": Body(told["base_radius_mm"] * normal + [0.0 * s, s], None, 0.0, 0.0, normal)}


def lever(given: dict, told: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    l, d, prime = given["arm_mm"], given["centre_distance_mm"], told["prime_radius_mm"]
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


def hinge(given: dict, told: Mapping[str, float], s: np.ndarray) -> dict[str, Body]:
    d, f = given["centre_distance_mm"], given["face_offset_mm"]
    direction = np.radians(given["pivot_direction_deg"])
    turn = -1.0 if given["sense"] == "opposite" else 1.0
    start = np.arcsin((told["base_radius_mm"] + f) / d)
    along = direction + np.pi + turn * (start + s / d)
    outward = heading(along + 0.5 * np.pi * turn)
    pivot = d * heading(np.array(direction))
    return {"": Body(pivot[:, None] - f * outward, pivot, turn, 0.0, outward)}
