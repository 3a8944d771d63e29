"""Forces of a cam at many angles, in floating point: what ``truth`` knows of loads and contact.

Everything follows from where the parts are: of a roller the path of its centre, of a face the line
of contact. Nothing is shared with the checker, nor with the product.
"""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.checker import truth

Json = dict[str, Any]
GRAVITY = 9.80665  # m/s²


def broken(question: Json, cam: Json, limit: Json, s: Any) -> float:
    """By how much a limit on forces is broken, relative; s to s''' per radian at the samples."""
    load, follower = question["load"], question["follower"]
    asked, chosen = load["spring"] or {}, cam.get("spring") or {}
    for name, value in chosen.items():  # what the question leaves free is in its range
        wanted = {"min": 0.0, "max": None} if asked[name] is None else asked[name]
        if value < 0.0 or truth.outside(wanted, value) > truth.NEAR:
            return 1.0
    if load.get("friction") is not None:
        return 1.0  # not what is evaluated here
    swung = follower["kind"].startswith("oscillating")
    force = drive(question, {**asked, **chosen}, s, swung)
    if limit["kind"] == "camshaft_torque":
        torque = force * (np.radians(s[1]) if swung else s[1]) * 1e-3
        return float(np.max(np.abs(torque)) / limit["max_n_m"] - 1.0)
    worst = -1.0
    for way, side, lever, radius, bend in contacts(question, cam, s):
        pressed = way * side * force / lever
        if limit["kind"] == "contact_force":
            size = float(np.max(np.abs(pressed)))
            most, least = (limit[name] for name in ("max_n", "min_n"))
            over = [] if most is None else [float(np.max(pressed)) - most]
            over += [] if least is None else [least - float(np.min(pressed))]
            worst = max(worst, *(each / size for each in over)) if over else worst
            continue
        contact = load["contact"]
        soft = sum((1.0 - each["poisson_ratio"] ** 2) / each["elastic_modulus_mpa"]
                   for each in (contact["cam"], contact["follower"]))  # fmt: skip
        with np.errstate(divide="ignore", invalid="ignore"):
            curved = 1.0 / radius + bend if radius else np.inf + bend
            square = pressed * curved / (math.pi * contact["width_mm"] * soft)
        square = np.where(pressed > 0.0, square, 0.0)
        worst = max(worst, float(np.max(square)) / limit["max_mpa"] ** 2 - 1.0)
    return worst


def drive(question: Json, spring: Json, s: Any, swung: bool) -> Any:
    """What the cam gives along the motion: N, of what swings N mm about its pivot."""
    load, omega = question["load"], question["speed_rpm"] * math.pi / 30.0
    s = np.radians(s) if swung else s
    names = ("moment_of_inertia_kg_m2", "damping_n_m_s_per_rad", "rate_n_m_per_rad",
             "preload_n_m", "moment_n_m")  # fmt: skip
    if not swung:
        names = ("moving_mass_kg", "damping_n_s_per_m", "rate_n_per_mm", "preload_n", "force_n")
    closure = question["follower"].get("closure") or {}
    side = -1.0 if closure.get("contact") == "inside" else 1.0
    metre, unit = (1.0, 1e3) if swung else (1e-3, 1.0)
    force = load[names[0]] * s[2] * omega**2 * metre + load[names[1]] * s[1] * omega * metre
    force = force + (spring.get(names[2]) or 0.0) * s[0] + side * (spring.get(names[3]) or 0.0)
    if load.get("rise_from_vertical_deg") is not None:
        force += load[names[0]] * GRAVITY * math.cos(math.radians(load["rise_from_vertical_deg"]))
    points = [(each["angle_deg"], each[names[4]]) for each in load["process"]]
    if points:
        (first, value), (last, before) = points[0], points[-1]
        at, values = zip((last - 360.0, before), *points, (first + 360.0, value), strict=True)
        force += np.interp(truth.angles(question), at, values)
    return force * unit


def contacts(question: Json, cam: Json, s: Any) -> Iterator[tuple[float, int, Any, float, Any]]:
    """Of every flank: 1 of the main path, −1 of a counter roller's; its side; drive over contact
    force; the roller's radius, ∞ of a face; and the profile's curvature."""
    follower = question["follower"]
    closure, kind = follower.get("closure") or {}, follower["kind"]
    if kind == "translating_flat_face":
        tilt = math.radians(follower["tilt_deg"])
        rho = cam["size"][0] + (s[0] + s[2]) * math.cos(tilt)
        yield 1.0, 1, math.cos(tilt), math.inf, 1.0 / rho
    elif kind == "oscillating_flat_face":
        along, _, rho, _ = truth.face_contact(question, cam, s)
        yield 1.0, 1, along, math.inf, 1.0 / rho
    elif kind == "oscillating_roller":
        free = not isinstance(follower["arm_mm"], float)
        lengths = [cam["size"][-1] if free else follower["arm_mm"], closure.get("arm_mm")]
        for k, (path, driven, _, flanks) in enumerate(truth.arm_paths(question, cam, s)):
            _, tangent, second = path
            speed, share = np.abs(tangent), np.conj(driven) * tangent
            bend = -(np.conj(tangent) * second).imag / speed**3
            for side, gap, _ in flanks:
                radius = closure["roller_radius_mm"] if k else follower["roller_radius_mm"]
                lever, own = lengths[k] * np.abs(share.imag) / speed, side * bend
                yield (-1.0 if k else 1.0), side, lever, radius, own / (1.0 - gap * own)
    else:
        for side, gap, _, way, e, s0 in truth.flanks(question, cam):
            x, u = s0 + way * s[0], way * s[1] - e
            w = np.hypot(x, u)
            bend = side * (x * x + u * (2.0 * way * s[1] - e) - x * way * s[2]) / w**3
            radius = (closure if way < 0.0 else follower)["roller_radius_mm"]
            yield way, side, x / w, radius, bend / (1.0 - gap * bend)
