"""An answer under attack: a cam better than its bound, or one where there is said to be none."""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import inf
from typing import Any

import numpy as np

from tests.hard.adversary.machine import Machine
from tests.hard.adversary.motion import Program
from tests.hard.adversary.search import HELD, Found, cams
from tests.hard.verifier import Cam, objectives, readings

AGREED = 1e-6  # relative: a cam this little better than a bound proves nothing
ALL_NUMBERS = "at all angles and lifts"
STEPS = (0.0, 0.003, 0.02, 0.1, 0.3, 1.0)
"""Of the way from the numbers chosen to random ones: a bound over all of them holds at each."""
BACKWARDS = 1e-9  # of a lift: what rounding may make of a law that rests
Spec = dict[str, Any]


def given_numbers(spec: Spec, random: np.random.Generator) -> Spec | None:
    """The question with random numbers in place of free angles, lifts and arms; None: none fit."""
    program, follower = [dict(segment) for segment in spec["program"]], dict(spec["follower"])
    signs = {"rise": 1.0, "return": -1.0}
    for name in ("angle_deg", "lift_mm", "lift_deg"):
        free = [i for i, segment in enumerate(program) if isinstance(segment.get(name), dict)]
        if not free:
            continue
        factor = [1.0 if name == "angle_deg" else signs.get(s["kind"], 1.0) for s in program]
        for _ in range(500):
            for i in free:
                ends = spec["program"][i][name]
                program[i][name] = float(random.uniform(ends["min"], ends["max"]))
            pairs = [(f, s.get(name) or 0.0) for f, s in zip(factor, program, strict=True)]
            missing = (360.0 if name == "angle_deg" else 0.0) - sum(f * v for f, v in pairs)
            last = free[-1]
            program[last][name] += missing * factor[last]
            ends = spec["program"][last][name]
            if ends["min"] <= program[last][name] <= ends["max"]:
                break
        else:
            return None
    if isinstance(follower.get("arm_mm"), dict):
        ends = follower["arm_mm"]
        follower["arm_mm"] = float(random.uniform(ends["min"], ends["max"]))
    return {**spec, "program": program, "follower": follower}


def is_modelled(spec: Spec) -> bool:
    """Whether the adversary has a formula for everything that the question asks."""
    random = np.random.default_rng(0)
    given = given_numbers(spec, random)
    if given is None or "spline_mm" in str(spec) or "table" in str(spec["program"]):
        return False
    return Machine(given, Program(given, lambda index: np.linspace(0.0, 1.0, 3))).modelled()


def is_open(design: dict[str, Any]) -> bool:
    """Whether an answer claims something over all cams: that there is none, or a bound."""
    proof = design["certificate"]
    covers = proof["lower_bound"] is not None and "spline" not in proof["bound_valid_for"]
    return bool(design["status"] in ("infeasible", "unsolved") or covers)


def refutation(spec: Spec, design: dict[str, Any], seconds: float, seed: int) -> str:
    """A cam that an answer says there is none of, in words; empty where none was found.

    Args:
        spec: the question. design: the answer, as on the wire. seconds: of processor time.
    """
    found = next(attempts(with_held_jerk(spec, design), design, seconds, seed), None)
    if found is None:
        return ""
    cam = json.dumps({"size": found.machine.wire(found.size), "value": found.value})
    if design["certificate"]["lower_bound"] is not None:
        return f"bound {design['certificate']['lower_bound']} beaten: {cam}"
    return f"{design['status']}, but there is a cam: {cam}"


def with_held_jerk(spec: Spec, design: dict[str, Any]) -> Spec:
    """The question where no objective is named: the rms jerk is held beside the base radius.

    The bound covers cams that keep to the cap on it, those of the answer's own rms jerk among them.
    """
    others = design["certificate"].get("other_objectives", [])
    own = [proof["value"] for proof in others if proof["objective"].startswith("rms_jerk")]
    return {**spec, HELD: own[0]} if own and spec.get("objective") is None else spec


def attempts(spec: Spec, design: dict[str, Any], seconds: float, seed: int) -> Iterator[Found]:
    """Cams that contradict an answer."""
    random = np.random.default_rng(seed)
    bound = design["certificate"]["lower_bound"]
    refused = bound is None
    below = inf if refused else bound * (1.0 - AGREED)
    known = design["certificate"]["value"] if objectives(spec)[0] == "base_radius" else None
    chosen = design.get("free_parameters") or {}
    free = any(isinstance(v, dict) for s in spec["program"] for v in s.values())
    everywhere = ALL_NUMBERS in design["certificate"]["bound_valid_for"]
    rounds = 6 if free and (everywhere or not chosen) else 1
    for turn in range(rounds):
        given = given_numbers(spec, random) if free and (turn or not chosen) else spec
        if chosen and given is not None:
            given = between(spec, given, chosen, STEPS[turn % len(STEPS)])
        if given is None:
            return
        kept: list[Found] = []

        def take(found: Found, given: Spec = given, kept: list[Found] = kept) -> bool:
            if (refused or found.value < below) and stands_up(given, found):
                kept.append(found)
            return bool(kept)

        hint = known if known is not None and known > 0.0 else None
        cams(given, seconds / rounds, seed + turn, hint, not refused, take)
        yield from kept


def with_numbers(spec: Spec, chosen: dict[str, float]) -> Spec:
    """The question with the numbers that an answer has chosen: its bound holds at these alone."""
    program, follower = [dict(segment) for segment in spec["program"]], dict(spec["follower"])
    for field, value in chosen.items():
        *_, index, name = field.strip("/").split("/")
        if index.isdigit():
            program[int(index)][name] = value
        elif index == "follower":
            follower[name] = value
    return {**spec, "program": program, "follower": follower}


def between(spec: Spec, other: Spec, chosen: dict[str, float], share: float) -> Spec:
    """The question with numbers a share of the way from those chosen to another one's.

    Sums of numbers stay what they are.
    """
    moved = {}
    for field, value in chosen.items():
        *_, index, name = field.strip("/").split("/")
        there = other["program"][int(index)] if index.isdigit() else other["follower"]
        known = share > 0.0 and not isinstance(there[name], dict)
        moved[field] = value + share * (there[name] - value) if known else value
    return with_numbers(spec, moved)


def stands_up(spec: Spec, found: Found) -> bool:
    """Whether the verifier finds every limit kept: the referee, whose formulas are others."""
    limits = [one for one in spec.get("limits", []) if one["kind"] not in (
        "contact_force", "camshaft_torque", "hertz_pressure")]  # fmt: skip
    judged = {**spec, "limits": limits}
    cam = Cam(judged, found.program.placed(found.laws), found.machine.wire(found.size))
    if any(reading.broken for reading in readings(cam)):
        return False
    for move in cam.moves:
        if move.free is not None and not move.free.get("overshoot", False):
            g = np.concatenate([g(np.linspace(a, b, 60), 0) for a, b, g in move.pieces])
            if np.max(np.maximum.accumulate(g) - g) > BACKWARDS:
                return False
    return _joins(cam)


def _joins(cam: Cam) -> bool:
    """Whether displacement, velocity and acceleration jump nowhere."""
    for order in range(3):
        for number, (before, after, scale, rounding) in enumerate(cam.joints(order)):
            left, right = cam.grids[number][0], cam.grids[(number + 1) % len(cam.grids)][0]
            free = [m.free for m in (left, right) if m.free is not None]
            promised = min((law.get("smoothness", 2) for law in free), default=0)
            question = max(promised, cam.spec.get("continuity") or 0)
            if order <= question and abs(after - before) > 1e-8 * scale + 10.0 * rounding:
                return False
    return True
