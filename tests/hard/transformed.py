"""Pairs of questions whose answers are related, whatever the answers are.

Where all cams of one question answer another one, the other's optimum is no worse; where both ask
for the same, both optima are equal. So intervals from lower bound to value must overlap, values may
differ by the tolerance where both gaps are within it, and asking for more never costs a proof.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.hard.families import random_scene
from tests.hard.own_numbers import solved
from tests.hard.verifier import Cam, peak, rebuilt

Spec = dict[str, Any]
ANYWHERE = 0.02  # relative: what an answer may be worse by than its partner's where gaps are open
ROUNDING = 1e-6  # relative
LOOSER = (1.01, 1.1, 2.0, 10.0, 1000.0)
STEEPEST = 89.9  # deg: the most that a pressure angle is loosened to
TIMES = {"per_s3": 3, "per_s2": 2, "per_s": 1, "hz": 1}


@dataclass(frozen=True)
class Answer:
    """What a question came to: value, lower bound and gap of the first objective."""

    status: str
    value: float | None
    bound: float | None
    gap: float | None
    seconds: float

    @property
    def has_cam(self) -> bool:
        return self.status in ("optimal", "feasible")


@dataclass(frozen=True)
class Transformed:
    """A question made from another one.

    Attributes:
        looser: its cams include the other's; else both ask for the same, or for cams among
            which the other's answer is. factor: of values, from one to the other. more: it asks
            for more than the other, by limits or accuracy, so that its gap is no wider.
    """

    kind: str
    body: Spec
    looser: bool = False
    factor: float = 1.0
    more: bool = False


# -- transformations -----------------------------------------------------------------------------


def loosened(body: Spec, random: np.random.Generator) -> Iterator[Transformed]:
    """One limit after another, by 1 % to 1000 times."""
    for i, limit in enumerate(body["limits"]):
        factor = float(random.choice(LOOSER))
        other = deepcopy(body)
        for name, value in limit.items():
            if not isinstance(value, (int, float)) or name == "natural_frequency_hz":
                continue
            least = name.startswith("min_") or name == "radius_mm"  # of a cutter: smaller is looser
            looser = value / factor if least else value * factor
            other["limits"][i][name] = min(looser, STEEPEST) if name.endswith("_deg") else looser
        yield Transformed(f"{limit['kind']} loosened {factor:g} times", other, looser=True)


def with_idle_limits(body: Spec, cam: Cam, random: np.random.Generator) -> Iterator[Transformed]:
    """Limits that the answer keeps, next to it or far away."""
    room = float(random.choice([1.001, 1.5, 100.0]))
    question = {limit["kind"] for limit in body["limits"]}
    for order, kind in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
        most = peak(cam, order) * cam.omega**order
        if kind not in question and np.isfinite(most):
            name = f"max_{cam.unit}_per_s{order if order > 1 else ''}"
            limits = [*body["limits"], {"kind": kind, name: most * room}]
            yield Transformed(f"idle {kind}, {room:g} times", {**body, "limits": limits}, more=True)


def more_accurate(body: Spec) -> Iterator[Transformed]:
    for share in (0.4, 0.05):
        tighter = {**body, "tolerance": share * body["tolerance"]}
        yield Transformed(f"tolerance {share:g} times", tighter, more=True)


def with_ranges(body: Spec, dimensions: dict[str, float], aim: str) -> Iterator[Transformed]:
    """Ranges that hold the answer's dimensions with room, and these dimensions themselves."""
    follower, base = body["follower"], dimensions["base_radius_mm"]
    if body.get("base_radius_mm") is None and aim == "base_radius":
        wide = {"min": 0.2 * base, "max": 20.0 * base}
        yield Transformed("base radius in a range", {**body, "base_radius_mm": wide}, more=True)
        most = {"max": base * (1.0 + 1e-6)}
        yield Transformed("largest base radius the answer's", {**body, "base_radius_mm": most})
    names = {"translating_roller": "offset_mm", "oscillating_roller": "centre_distance_mm"}
    name = names.get(follower["kind"])
    if name is None or isinstance(follower.get(name), (int, float)):
        return
    value = dimensions[name]
    if follower.get(name) is None:
        far = 10.0 * (abs(value) + base)
        low = -far if name == "offset_mm" else 0.1 * value
        named = {**follower, name: {"min": low, "max": far}}
        yield Transformed(f"{name} in a range", {**body, "follower": named}, more=True)
    yield Transformed(f"{name} the answer's", {**body, "follower": {**follower, name: value}})


def scaled(body: Spec, random: np.random.Generator) -> Iterator[Transformed]:
    """All lengths by one factor, and all times by another; not with a load."""
    if "load" in body:
        return
    length = float(10.0 ** random.uniform(-3.0, 3.0))
    aim = _aim(body)
    slides = body["follower"]["kind"].startswith("translating")
    by_length = length if aim == "base_radius" or (slides and aim != "peak_pressure_angle") else 1.0
    yield Transformed(f"lengths {length:g} times", _times(body, length, 1.0), factor=by_length)
    pace = float(10.0 ** random.uniform(-2.0, 2.0))
    order = {"jerk": 3, "acceleration": 2, "velocity": 1}.get(aim.split("_")[-1], 0)
    yield Transformed(f"speed {pace:g} times", _times(body, 1.0, pace), factor=pace**order)


def _times(node: Any, length: float, pace: float, name: str = "") -> Any:
    if isinstance(node, dict):
        ends = ("min", "max")  # of a range that has the unit in its name
        return {k: _times(v, length, pace, name if k in ends else k) for k, v in node.items()}
    if isinstance(node, list):
        return [_times(value, length, pace, name) for value in node]
    if isinstance(node, bool) or not isinstance(node, (int, float)):
        return node
    order = next((n for end, n in TIMES.items() if name.endswith(end)), 0)
    found = node * pace ** (1 if name == "speed_rpm" else order)
    return found * length if "mm" in name.split("_") else found


def turned(body: Spec, random: np.random.Generator) -> Iterator[Transformed]:
    """The program from another segment on."""
    program = body["program"]
    first = int(random.integers(1, len(program)))
    yield Transformed("turned", {**body, "program": [*program[first:], *program[:first]]})


def mirrored(body: Spec) -> Iterator[Transformed]:
    """Run backwards: rises are returns, the offset and the sense of an arm change sides."""
    free = all(s.get("law", {"kind": "spline"})["kind"] == "spline" for s in body["program"])
    inside = any(s.get("windows") or s.get("points") for s in body["program"])
    if not free or inside or "load" in body or body["follower"].get("tilt_deg"):
        return
    swap = {"rise": "return", "return": "rise", "dwell": "dwell"}
    program = [{**s, "kind": swap[s["kind"]]} for s in reversed(body["program"])]
    limits = [
        {**one, "rise_deg": one["return_deg"], "return_deg": one["rise_deg"]}
        if one["kind"] == "pressure_angle" else one
        for one in body["limits"]
    ]  # fmt: skip
    follower = dict(body["follower"])
    if "sense" in follower:
        follower["sense"] = {"same": "opposite", "opposite": "same"}[follower["sense"]]
    offset = follower.get("offset_mm")
    if isinstance(offset, dict):
        follower["offset_mm"] = {"min": -offset["max"], "max": -offset["min"]}
    elif offset:
        follower["offset_mm"] = -offset
    if (follower.get("closure") or {}).get("offset_mm"):
        return
    both = {"program": program, "limits": limits, "follower": follower}
    yield Transformed("run backwards", {**body, **both})


def transformations(body: Spec, design: dict[str, Any], seed: int) -> Iterator[Transformed]:
    """Every question that is made of one, and of its answer."""
    random = np.random.default_rng(seed)
    yield from loosened(body, random)
    yield from more_accurate(body)
    yield from scaled(body, random)
    yield from turned(body, random)
    yield from mirrored(body)
    if not design.get("free_parameters"):
        yield from with_ranges(body, design["dimensions"], _aim(body))
        yield from with_idle_limits(body, rebuilt(body, design), random)


def _aim(body: Spec) -> str:
    question = body.get("objective") or {"kind": "base_radius"}
    return str((question[0] if isinstance(question, list) else question)["kind"])


# -- judgement -----------------------------------------------------------------------------------


def answered(body: Spec) -> tuple[Answer, Any]:
    # Without a time a proof ends after a number of programs: the same for both of a pair.
    status, design, seconds = solved({**body, "time_budget_s": None})
    if design is None:
        return Answer(status, None, None, None, seconds), None
    proof = design.certificate
    # a bound at numbers that were chosen says nothing of others
    bound, gap = (None, None) if design.free_parameters else (proof.lower_bound, proof.gap)
    return Answer(status, proof.value, bound, gap, seconds), design


def faults(question: Spec, first: Answer, other: Transformed, second: Answer) -> Iterator[str]:
    """What two related answers say against each other."""
    if first.value is None or not first.has_cam:
        return
    value = first.value * other.factor
    if not second.has_cam or second.value is None:
        yield f"lost: {second.status}, though the partner's cam does"
        return
    if first.bound == 0.0:
        return  # no cam is the best: what comes near to the infimum is as small as is sought
    tolerance = question["tolerance"]
    closed = all(a.gap is not None and a.gap <= tolerance for a in (first, second))
    allowed = tolerance if closed else ANYWHERE
    if second.value > value * (1.0 + allowed) + ROUNDING * abs(value):
        yield f"worse: {second.value:.6g} after {value:.6g}"
    if second.bound is not None and second.bound > value * (1.0 + ROUNDING):
        yield f"bound {second.bound:.6g} above the partner's cam {value:.6g}"
    if other.looser:
        return
    if value > second.value * (1.0 + allowed) + ROUNDING * abs(value):
        yield f"the partner is worse: {value:.6g}, though there is {second.value:.6g}"
    if first.bound is not None and first.bound * other.factor > second.value * (1.0 + ROUNDING):
        yield f"its cam {second.value:.6g} below the partner's bound {first.bound:.6g}"
    if other.more and first.gap is not None:
        wider = second.gap is None or second.gap > max(first.gap, tolerance) + ANYWHERE * first.gap
        if wider:
            yield f"gap {second.gap} for having asked more, {first.gap} before"


def pairs(family: str, number: int) -> Iterator[tuple[Transformed, Answer, list[str]]]:
    """Every transformed question of a scene, its answer, and what is wrong with it."""
    body = random_scene(family, number)
    first, design = answered(body)
    if design is None or not first.has_cam:
        return
    for other in transformations(body, design.model_dump(mode="json"), number):
        second, _ = answered(other.body)
        yield other, second, list(faults(body, first, other, second))
