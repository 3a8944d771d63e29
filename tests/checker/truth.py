"""Whether what a proof file claims is true: floating point, sampling, and the optimiser.

It shares nothing with the checker. A cam's limits are evaluated at many angles by the textbook's
formulas; a bound is contradicted by a cam of the same question that is better, and so is a claim
that there is none.
"""

import math
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from pydantic import ValidationError
from scipy.integrate import cumulative_simpson
from scipy.interpolate import BSpline

from synthesis import DesignSpec, synthesise
from synthesis.errors import CamwrightError
from tests.checker import truth_of_forces

Json = dict[str, Any]
SAMPLES = 4000  # of a segment
POWERS = {  # lowest power, coefficients
    "polynomial_3_4_5": (3, (10, -15, 6)), "polynomial_4_5_6_7": (4, (35, -84, 70, -20)),
}  # fmt: skip
PARTS = {  # of sine, constant and cosine acceleration
    "cycloidal": (0.5, 0.0, 0.5), "modified_sine": (0.25, 0.0, 0.75),
    "modified_trapezoid": (0.25, 0.5, 0.25), "simple_harmonic": (0.0, 0.0, 1.0),
}  # fmt: skip
FORCES = ("contact_force", "camshaft_torque", "hertz_pressure")
NEAR = 1e-6  # relative: what sampling and floating point may miss


def contradiction(proof: Json, known: Json | None = None) -> str:
    """Why a claim of a file that was accepted is false; empty where none is.

    ``known``: a file whose claims are true; what this one claims as well is not looked at again.
    """
    claims = {claim["place"]: claim for claim in proof["claims"] if claim["proven"] is True}
    true = {claim["place"]: claim for claim in known["claims"]} if known else {}
    same = known is not None and all(known[part] == proof[part] for part in ("question", "cam"))
    for place, claim in claims.items():
        known_claim = true.get(place, {})
        if same and all(known_claim.get(part) == claim.get(part) for part in ("at_least", "held")):
            continue
        if place == "infeasible" or place.startswith("objective/"):
            found = better_cam(proof["question"], place, claim)
        else:
            found = broken(proof, place)
        if found:
            return f"{place}: {found}"
    return ""


def better_cam(question: Json, place: str, claim: Json) -> str:
    """A cam that there should not be."""
    aims, earlier, values = question["objective"], list[Json](), list[float]()
    aims = aims if isinstance(aims, list) else [aims]
    held = claim.get("held", [])
    for k, aim in enumerate(aims[: 1 + len(held)]):
        # what may be added to the value reached, so that all that is held is used up
        body = {**question, "objective": [*earlier, aim], "time_budget_s": 3.0}
        try:
            spec = DesignSpec.model_validate(body)
            design = synthesise(spec)
        except (ValidationError, CamwrightError):
            return ""  # no question that can be asked
        if not design.certificate.certified:
            return ""
        if place == "infeasible":
            return f"the question has a cam with {design.objectives}"
        names = [each.name_on_wire(spec.machine()) for each in spec.objectives()]
        values = [design.objectives[name] for name in names]
        if any(value > most for value, most in zip(values, held, strict=False)):
            return ""
        if k < len(held):
            share = held[k] / values[k] - 1.0 if values[k] > 0.0 else 0.0
            earlier.append({**aim, "allowance": min(share, 9.0) or None})
    if values[-1] < claim["at_least"] * (1.0 - NEAR):
        return f"a cam with {values} is better than {claim['at_least']}"
    return ""


def broken(proof: Json, place: str) -> str:
    """What the cam of the file breaks at a place of the list of claims."""
    question, cam = proof["question"], proof["cam"]
    s, sense, may_overshoot = motion(question, cam)
    omega = question["speed_rpm"] * math.pi / 30.0
    follower = question["follower"]
    roller = follower["kind"] != "translating_flat_face"
    swinging = follower["kind"] == "oscillating_flat_face"
    limit = question["limits"][int(place[7:])] if place.startswith("limits/") else {"kind": place}
    kind, worst = limit["kind"], 0.0
    orders = {"velocity": 1, "acceleration": 2, "jerk": 3}
    if kind in orders:
        k, unit = orders[kind], "deg" if follower["kind"].startswith("oscillating") else "mm"
        most = limit[f"max_{unit}_per_s" + ("", "2", "3")[k - 1]]
        worst = np.max(np.abs(s[k])) * omega**k / most - 1.0
    elif kind == "motion":
        jumps = [np.max(np.abs(np.diff(s[k]))) / max(np.ptp(s[k]), 1e-300) for k in (0, 1)]
        back = np.min(s[1] * sense * ~may_overshoot) / np.max(np.abs(s[1]))
        worst = max(max(jumps) - 0.05, -back)
    elif kind in FORCES:
        worst = truth_of_forces.broken(question, cam, limit, s)
    elif place.startswith("program/"):
        _, index, name = place.split("/")
        worst = outside_bounds(question, cam, int(index), name)
    elif swinging:
        worst = broken_on_face(limit, sense, *face_contact(question, cam, s))
        if kind == "size":
            (p, q), f = cam["size"], follower["face_offset_mm"]
            worst = max(worst, outside(follower["centre_distance_mm"], math.hypot(p, q)),
                        outside(question["base_radius_mm"], q - f))  # fmt: skip
    elif follower["kind"] == "oscillating_roller":
        worst = max(broken_on_path(limit, *each, sense) for each in arm_paths(question, cam, s))
        if kind == "size":
            worst = arm_outside(question, cam)
    elif roller:
        worst = max(broken_flank(limit, s, sense, flank) for flank in flanks(question, cam))
        if kind == "size":
            e, s0, *apart = cam["size"]
            distance = follower["closure"].get("distance_mm")
            worst = outside(question["base_radius_mm"], math.hypot(e, s0) - gap_of(question))
            worst = max(worst, outside(follower["offset_mm"], e))
            worst = max(worst, *(outside(distance, each) for each in apart), 0.0)
    else:
        (base,), tilt = cam["size"], math.radians(follower["tilt_deg"])
        rho = base + (s[0] + s[2]) * math.cos(tilt)
        if kind in ("profile_radius", "no_undercut", "self_crossing"):
            worst = ((limit.get("min_mm") or 0.0) - np.min(rho)) / base
        elif kind == "face_width":
            half = (limit["width_mm"] or math.inf) / 2.0
            right, left = (min(limit[f"{side}_mm"] or math.inf, half) for side in ("right", "left"))
            offset = follower["offset_mm"]
            at = s[1] * math.cos(tilt) - s[0] * math.sin(tilt) - base * math.tan(tilt)
            at = at - offset / math.cos(tilt)
            worst = max(np.max(at) - right, -np.min(at) - left) / base
        elif kind == "size":
            worst = outside(question["base_radius_mm"], base)
    return f"broken by {worst}" if not worst <= NEAR else ""


def gap_of(question: Json) -> float:
    """The prime radius less the base radius."""
    follower = question["follower"]
    closure = follower.get("closure") or {}
    gap = float(follower["roller_radius_mm"]) + (closure.get("clearance_mm") or 0.0) / 2.0
    return -gap if closure.get("contact") == "inside" else gap


def flanks(question: Json, cam: Json) -> list[tuple[int, float, float, float, float, float]]:
    """Side, distance from the path, rim, sense of s, offset and height of the path's follower."""
    closure = question["follower"].get("closure") or {}
    e, s0, *apart = cam["size"]
    gap, rim = gap_of(question), closure.get("rim_mm") or 0.0
    if gap < 0.0:
        return [(-1, -gap, rim, 1.0, e, s0)]
    found = [(1, gap, 0.0, 1.0, e, s0)]
    if closure.get("kind") == "groove":
        found.append((-1, gap, rim, 1.0, e, s0))
    if apart:
        found.append(
            (1, closure["roller_radius_mm"], 0.0, -1.0, -closure["offset_mm"], apart[0] - s0)
        )
    return found


def broken_flank(limit: Json, s: Any, sense: Any, flank: Any) -> float:
    """By how much a limit is broken on one flank under a roller."""
    side, gap, rim, way, e, s0 = flank
    s, kind = way * s, limit["kind"]
    x, u = s0 + s[0], s[1] - e
    w = np.hypot(x, u)
    bend = side * (x * x + u * (2.0 * s[1] - e) - x * s[2]) / w**3
    far = np.hypot(x, e)
    if kind == "pressure_angle":
        names = {1.0: "rise_deg", -1.0: "return_deg", 0.0: "dwell_deg"}
        most = np.array([math.tan(math.radians(limit[names[k]] or 89.9999)) for k in sense])
        return float(np.max(np.abs(u) - most * x) / np.max(w))
    if kind in ("profile_radius", "no_undercut", "self_crossing"):
        return float(np.max(bend) * (gap + (limit.get("min_mm") or 0.0)) - 1.0)
    if kind == "cutter_radius":
        return float(np.max(-bend) * max(limit["radius_mm"] - gap, 0.0) - 1.0)
    if kind == "outer_radius":
        return float((np.max(far) - side * gap + rim) / limit["max_mm"] - 1.0)
    if kind == "counter_base_radius" and way < 0.0:
        return float(1.0 - (np.min(far) - gap) / max(limit["min_mm"], 1e-300))
    return -1.0


def arm_paths(question: Json, cam: Json, s: Any) -> Iterator[tuple[Any, Any, Any, list[Any]]]:
    """Of every roller on an arm its centre's path, driven direction, and flanks.

    With the pivot at d on the real axis the arm points along −exp(−iσψ); the path is seen from the
    cam, which turns counter-clockwise: P exp(iθ), P′ exp(iθ), P″ exp(iθ).
    """
    follower, gap = question["follower"], gap_of(question)
    closure = follower.get("closure") or {}
    p, q, *more = cam["size"]
    arm = follower["arm_mm"] if isinstance(follower["arm_mm"], float) else more.pop()
    d, sigma = math.hypot(p, q), 1.0 if follower["sense"] == "opposite" else -1.0
    turn = np.radians(s)
    turn[0] += math.atan2(q, p)
    flanks = [(-1 if gap < 0.0 else 1, abs(gap), closure.get("rim_mm") or 0.0)]
    if closure.get("kind") == "groove":
        flanks = [(1, gap, 0.0), (-1, gap, closure["rim_mm"])]
    found = [(sigma, turn, arm, flanks)]
    if more:
        other = -turn
        other[0] += math.radians(more[0])
        found.append((-sigma, other, closure["arm_mm"], [(1, closure["roller_radius_mm"], 0.0)]))
    for way, psi, length, own in found:
        along = length * np.exp(-1j * way * psi[0])
        at, speed = d - along, 1j * way * psi[1] * along
        bend = (1j * way * psi[2] + psi[1] ** 2) * along
        path = np.array([at, speed - 1j * at, bend - 2j * speed - at])
        yield path, 1j * way * along / length, np.sin(psi[0]), own


def broken_on_path(
    limit: Json, path: Any, driven: Any, across: Any, flanks: list[Any], sense: Any
) -> float:
    """By how much a limit is broken along the path of a roller's centre."""
    at, tangent, second = path
    kind, speed = limit["kind"], np.abs(tangent)
    if kind == "pressure_angle":
        names = {1.0: "rise_deg", -1.0: "return_deg", 0.0: "dwell_deg"}
        most = np.array([math.tan(math.radians(limit[names[k]] or 89.9999)) for k in sense])
        share = np.conj(driven) * tangent
        return float(np.max(np.abs(share.real) - most * np.abs(share.imag)) / np.max(speed))
    if np.min(across) <= 0.0:
        return 1.0
    worst, curvature = -1.0, -(np.conj(tangent) * second).imag / speed**3
    for side, gap, rim in flanks:
        if kind in ("profile_radius", "no_undercut", "self_crossing"):
            found = np.max(side * curvature) * (gap + (limit.get("min_mm") or 0.0)) - 1.0
        elif kind == "cutter_radius":
            found = np.max(-side * curvature) * max(limit["radius_mm"] - gap, 0.0) - 1.0
        elif kind == "outer_radius":
            found = (np.max(np.abs(at)) - side * gap + rim) / limit["max_mm"] - 1.0
        else:
            found = -1.0
        worst = max(worst, float(found))
    return worst


def angles(question: Json) -> Any:
    """The cam angles of the samples [deg]."""
    moving = [each["angle_deg"] for each in question["program"] if each["angle_deg"]]
    step = np.repeat(np.array(moving) / SAMPLES, SAMPLES)
    return np.cumsum(step) - step / 2.0


def face_contact(question: Json, cam: Json, s: Any) -> tuple[Any, Any, Any, float]:
    """Of a face that swings where contact is along it, the points of the cam, and its radius.

    The axis is at 0, the pivot at −d on the real axis, exp(iψ) runs along the face. Points are seen
    from the cam, and their differences give the radius, which is negative where it is undercut.
    """
    follower, (p, q) = question["follower"], cam["size"]
    way = 1.0 if follower["sense"] == "opposite" else -1.0
    d, f = math.hypot(p, q), follower["face_offset_mm"]
    psi, speed = math.atan2(q, p) + np.radians(s[0]), np.radians(s[1])
    along = d * np.cos(psi) / (1.0 + way * speed)
    moving = [each["angle_deg"] for each in question["program"] if each["angle_deg"]]
    theta = np.radians(angles(question))
    turned = np.exp(1j * (psi + way * theta))
    points = -d * np.exp(1j * way * theta) + (along - 1j * f) * turned
    ends = np.cumsum([0] + [SAMPLES] * len(moving))
    rate = np.concatenate([np.gradient(points[a:b], theta[a:b]) for a, b in pairwise(ends)])
    radius = -(np.conj(turned) * rate).real / (way + speed)
    return along, points, radius, f


def broken_on_face(
    limit: Json, sense: Any, along: Any, points: Any, radius: Any, away: float
) -> float:
    """By how much a limit is broken on a face that swings."""
    kind = limit["kind"]
    if np.min(along) <= 0.0:
        return 1.0
    size = float(np.max(np.abs(points)))
    if kind == "pressure_angle":
        names = {1.0: "rise_deg", -1.0: "return_deg", 0.0: "dwell_deg"}
        most = np.array([math.tan(math.radians(limit[names[k]] or 89.9999)) for k in sense])
        return float(np.max(abs(away) - most * along) / size)
    if kind in ("profile_radius", "no_undercut", "self_crossing"):
        return float(((limit.get("min_mm") or 0.0) - np.min(radius)) / size)
    if kind == "face_width":
        near, far = limit["near_mm"] or 0.0, limit["far_mm"] or math.inf
        return float(max(near - np.min(along), np.max(along) - far) / size)
    return size / limit["max_mm"] - 1.0 if kind == "outer_radius" else -1.0


def arm_outside(question: Json, cam: Json) -> float:
    """How far the sizes of an arm lie outside what was asked."""
    follower = question["follower"]
    p, q, *more = cam["size"]
    free = not isinstance(follower["arm_mm"], float)
    arm = more.pop() if free else follower["arm_mm"]
    found = [(follower["arm_mm"], arm), (follower["centre_distance_mm"], math.hypot(p, q)),
             (question["base_radius_mm"], math.hypot(p - arm, q) - gap_of(question))]  # fmt: skip
    found += [(follower["closure"].get("angle_deg"), each) for each in more]
    return max(outside(*each) for each in found)


def outside_bounds(question: Json, cam: Json, index: int, name: str) -> float:
    """By how much windows or points of a segment are left."""
    s, *_ = motion(question, cam)
    rate, segments = 6.0 * question["speed_rpm"], question["program"]
    angles = [each["angle_deg"] for each in segments]
    first = SAMPLES * sum(angle > 0.0 for angle in angles[:index])
    part = s[:, first : first + SAMPLES]
    x = (np.arange(SAMPLES) + 0.5) / SAMPLES * angles[index]
    way, worst = -1.0 if segments[index]["kind"] == "return" else 1.0, 0.0
    for each in segments[index][name]:
        ends = [each.get(k, each.get("angle_deg")) for k in ("from_deg", "to_deg")]
        at = np.union1d(x[(ends[0] <= x) & (x <= ends[1])], np.clip(ends, x[0], x[-1]))
        fields = ("travel_mm", "velocity_mm_per_s", "acceleration_mm_per_s2", "jerk_mm_per_s3")
        for k, field in enumerate(fields):
            per_second = part[k] * math.radians(rate) ** k
            value = np.interp(at, x, per_second if k else way * (per_second - per_second[0]))
            scale, slack = np.ptp(per_second) + 1e-300, each.get("tolerance_mm") or 0.0
            over = max(outside(each.get(field), y) * abs(y) for y in value)
            worst = max(worst, (over - (0.0 if k else slack)) / scale - 1e-4)
    return worst


def outside(asked: Any, value: float) -> float:
    """How far a value lies outside what was asked."""
    low, high = (
        (asked, asked)
        if isinstance(asked, (int, float))
        else (((asked or {}).get("min"), (asked or {}).get("max")))
    )
    below = 0.0 if low is None else low - value
    above = 0.0 if high is None else value - high
    return max(below, above, 0.0) / max(abs(value), 1e-300)


@cache
def given(kind: str | None) -> Any:
    """A given law and three derivatives at the samples: its acceleration, integrated."""
    x = (np.arange(SAMPLES) + 0.5) / SAMPLES
    if kind is None:
        return np.array([x, np.ones(SAMPLES), np.zeros(SAMPLES), np.zeros(SAMPLES)])
    if kind in POWERS:
        g = Polynomial([0.0] * POWERS[kind][0] + list(POWERS[kind][1]))
        return np.array([g(x), *(g.deriv(k)(x) for k in (1, 2, 3))])
    b, c, d = PARTS[kind]
    fine = np.linspace(0.0, 1.0, 40 * SAMPLES + 1)
    y = np.minimum(fine, 1.0 - fine)
    with np.errstate(divide="ignore", invalid="ignore"):
        waves = np.sin(np.pi * y / b), np.ones_like(y), np.cos(np.pi * (y - (b + c) / 2) / d)
    shape = np.select([y < b / 2, y <= (b + c) / 2, y < (b + c + d) / 2], waves)
    a = shape * np.where(fine <= 0.5, 1.0, -1.0)
    v = cumulative_simpson(a, x=fine, initial=0.0)
    s = cumulative_simpson(v, x=fine, initial=0.0)
    table = np.array([s, v, a, np.gradient(a, fine)]) / s[-1]
    return table[:, 20::40]


def motion(question: Json, cam: Json) -> tuple[Any, Any, Any]:
    """s to s''' per radian at many angles, the sense of the move, and whether it may overshoot."""
    columns, senses, may, level, levels = [], [], [], 0.0, [0.0]
    rate = 6.0 * question["speed_rpm"]
    x = (np.arange(SAMPLES) + 0.5) / SAMPLES
    for segment, law in zip(question["program"], cam["laws"], strict=True):
        beta = math.radians(segment["angle_deg"])
        lift = (
            segment.get("lift_mm")
            or segment.get("lift_deg")
            or (segment.get("velocity_mm_per_s") or 0.0) * (segment["angle_deg"] / rate)
        )
        lift = -lift if segment["kind"] == "return" else lift
        table = np.zeros((4, SAMPLES))
        if law is None:
            g = given((segment.get("law") or {}).get("kind"))
            for k in range(4 if beta else 1):
                table[k] = lift * g[k] / (beta**k if k else 1.0)
            table[0] += level
        else:
            p = int(law["degree"])
            knots = [0.0] * p + list(law["knots"]) + [1.0] * p
            g = BSpline(np.array(knots), np.array(law["coefficients"], dtype=float), p)
            for k in range(4):
                table[k] = lift / beta**k * g(x, k)
            table[0] += level
        if beta:
            columns.append(table)
            senses.append(np.full(SAMPLES, float(np.sign(lift))))
            may.append(np.full(SAMPLES, bool((segment.get("law") or {}).get("overshoot"))))
        level += lift
        levels.append(level)
    s = np.concatenate(columns, axis=1)
    s[0] -= min(levels)
    return s, np.concatenate(senses), np.concatenate(may)
