"""The adversary finds what is known, and its formulas are those of the verifier."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.hard.adversary.attack import is_modelled, refutation, stands_up, with_held_jerk
from tests.hard.adversary.machine import Machine
from tests.hard.adversary.motion import Program
from tests.hard.adversary.search import HELD, Attack, Found, cams
from tests.hard.families import FAMILIES, random_scene
from tests.hard.own_laws import named
from tests.hard.own_ringing import amplitudes
from tests.hard.verifier import Cam, readings

HERE = Path(__file__).parent / "adversary"
ALONE = ("own_cam", "own_laws", "verifier")  # of this directory; they import nothing either
ENOUGH_S = 600.0  # of processor time: an attack ends when it has found something, long before
NARROW: dict[str, Any] = {
    "program": [
        {"kind": "rise", "angle_deg": 71.0, "lift_mm": 13.7, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 42.0},
        {"kind": "return", "angle_deg": 97.0, "lift_mm": 13.7, "law": {"kind": "spline"}},
        {"kind": "dwell", "angle_deg": 150.0},
    ],
    "speed_rpm": 113.0,
    "follower": {"kind": "translating_roller", "roller_radius_mm": 4.1, "offset_mm": 0.0},
}
LEAST_JERK = 32.0 * 13.7 * (6.0 * 113.0 / 71.0) ** 3


@pytest.mark.parametrize("file", sorted(HERE.glob("*.py")), ids=lambda file: file.stem)
def test_it_imports_nothing_of_the_product(file: Path) -> None:
    tree = ast.parse(file.read_text())
    names = [a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names]
    names += [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    for name in names:
        assert name.split(".")[0] not in ("synthesis", "service"), name
        own = name.startswith("tests.hard.adversary") or name.removeprefix("tests.hard.") in ALONE
        assert own or not name.startswith("tests"), name


def answer(status: str, bound: float | None, value: float | None = None) -> dict[str, Any]:
    proof = {"lower_bound": bound, "value": value, "bound_valid_for": "every motion law"}
    return {"status": status, "certificate": proof, "free_parameters": {}}


def test_the_least_peak_jerk_is_found_and_not_beaten() -> None:
    question = {**NARROW, "objective": {"kind": "peak_jerk"}, "base_radius_mm": 80.0}
    best: list[Found] = []

    def take(found: Found) -> bool:
        best.append(found)
        return found.value < LEAST_JERK * 1.03

    cams(question, ENOUGH_S, 3, None, True, take)
    assert stands_up(question, best[-1])
    assert LEAST_JERK * (1.0 - 1e-6) < best[-1].value < LEAST_JERK * 1.03


def test_a_bound_that_is_too_high_is_beaten_and_a_true_one_is_not() -> None:
    question = {**NARROW, "objective": {"kind": "peak_jerk"}, "base_radius_mm": 80.0}
    assert refutation(question, answer("optimal", 1.1 * LEAST_JERK), ENOUGH_S, 1)
    assert not refutation(question, answer("optimal", (1.0 - 1e-5) * LEAST_JERK), 0.3, 1)


QUIET = {"kind": "residual_vibration", "natural_frequency_hz": 23.0, "max_mm": 0.043}


@pytest.mark.parametrize("more", [[], [QUIET]], ids=["", "residual vibration"])
def test_a_smaller_cam_than_a_false_bound_is_found(more: list[dict[str, Any]]) -> None:
    limits = [
        {"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 33.0},
        {"kind": "jerk", "max_mm_per_s3": 1.9 * LEAST_JERK, "max_deg_per_s3": None},
        *more,
    ]
    question = {**NARROW, "limits": limits}
    assert refutation(question, answer("optimal", 60.0, 60.0), ENOUGH_S, 1)


def test_a_refusal_that_is_none_is_refuted_and_a_true_one_is_not() -> None:
    for share, refuted in ((1.02, True), (0.98, False)):
        limits = [{"kind": "jerk", "max_mm_per_s3": share * LEAST_JERK}]
        question = {**NARROW, "limits": limits, "base_radius_mm": {"max": 300.0}}
        seconds = ENOUGH_S if refuted else 0.1
        assert bool(refutation(question, answer("infeasible", None), seconds, 2)) == refuted


CONJUGATE = {"kind": "conjugate", "roller_radius_mm": 5.0, "offset_mm": 1.3, "distance_mm": 96.0}
ARMS = {"kind": "conjugate", "roller_radius_mm": 6.0, "arm_mm": 71.0, "angle_deg": 118.0}
FOLLOWERS: dict[str, tuple[dict[str, Any], list[float]]] = {
    "slide": ({"kind": "translating_roller", "roller_radius_mm": 4.3}, [3.1, 37.7]),
    "conjugate": (
        {"kind": "translating_roller", "roller_radius_mm": 4.3, "closure": CONJUGATE},
        [3.1, 37.7, 96.0],
    ),
    "ring": (
        {"kind": "translating_roller", "roller_radius_mm": 4.3,
         "closure": {"kind": "force", "contact": "inside", "rim_mm": 3.0}}, [-2.2, 37.7]),
    "groove": (
        {"kind": "translating_roller", "roller_radius_mm": 4.3,
         "closure": {"kind": "groove", "clearance_mm": 0.1, "rim_mm": 3.0}}, [-2.2, 37.7]),
    "face": ({"kind": "translating_flat_face"}, [61.0]),
    "tilted face": (
        {"kind": "translating_flat_face", "tilt_deg": 11.0, "offset_mm": 2.7}, [61.0]),
    "arm": (
        {"kind": "oscillating_roller", "roller_radius_mm": 7.0, "arm_mm": 83.0}, [0.43, 97.0]),
    "arm, same sense": (
        {"kind": "oscillating_roller", "roller_radius_mm": 7.0, "arm_mm": 83.0, "sense": "same"},
        [0.43, 97.0]),
    "arms": (
        {"kind": "oscillating_roller", "roller_radius_mm": 7.0, "arm_mm": 83.0, "closure": ARMS},
        [0.43, 97.0, 2.06]),
    "swinging face": (
        {"kind": "oscillating_flat_face", "centre_distance_mm": 97.0, "face_offset_mm": 4.0},
        [0.31, 97.0]),
    "swinging face, same sense": (
        {"kind": "oscillating_flat_face", "centre_distance_mm": 97.0, "sense": "same"},
        [0.61, 97.0]),
}  # fmt: skip


@pytest.mark.parametrize("name", FOLLOWERS)
def test_its_formulas_are_the_verifiers(name: str) -> None:
    """Limits at values that the verifier measures are met exactly by the adversary's formulas."""
    follower, z = FOLLOWERS[name]
    swings = follower["kind"].startswith("osc")
    unit = "deg" if swings else "mm"
    program = [
        {("lift_" + unit if key == "lift_mm" else key): value for key, value in segment.items()}
        for segment in NARROW["program"]
    ]
    spec = {**NARROW, "program": program, "follower": follower, "limits": []}
    made = Program(spec, lambda index: np.linspace(0.0, 1.0, 9))
    # the law 3-4-5 as well as 8 pieces can
    joined, values = made.joined()
    wanted = np.zeros(made.count)
    for law in made.laws.values():
        middle = 0.5 * (law.breaks[1:] + law.breaks[:-1])
        jerk = named({"kind": "polynomial_3_4_5"}, "rise")[0][2](middle, 3)
        wanted[law.first + 2 : law.first + law.count] = jerk
    laws = wanted + np.linalg.lstsq(joined, values - joined @ wanted, rcond=None)[0]
    size = np.array([*z, 0.0])
    wire = Machine(spec, made).wire(size)
    limits = [{"kind": "profile_radius", "min_mm": 1.0}, {"kind": "outer_radius", "max_mm": 1e3}]
    if follower["kind"] != "translating_flat_face":
        limits.append({"kind": "pressure_angle", "rise_deg": 60.0, "return_deg": 60.0})
    if "flat_face" in follower["kind"]:
        both = {"near_mm": 1.0, "far_mm": 99.0} if swings else {"left_mm": 99.0, "right_mm": 99.0}
        limits.append({"kind": "face_width", **both})
    else:
        limits.append({"kind": "cutter_radius", "radius_mm": 500.0})
    limits.append({"kind": "jerk", f"max_{unit}_per_s3": 1e9})
    compared: list[str] = []
    for limit in limits:
        for key in [key for key in limit if key != "kind"]:
            question = {**spec, "limits": [{"kind": limit["kind"], key: limit[key]}]}
            cam = Cam(question, made.placed(laws), wire)
            measured = [one for one in readings(cam) if one.name.startswith(_reading(limit, key))]
            worst = max(measured, key=lambda one: one.value / one.bound)
            at = worst.wire(worst.value)
            if at is None or not np.isfinite(at) or at <= 0.0 or worst.value == 0.0:
                continue
            tight = {**spec, "limits": [{"kind": limit["kind"], key: at}]}
            attack = Attack(Program(tight, lambda index: np.linspace(0.0, 1.0, 9)))
            ours = [q for q in attack.quantities if q.name == limit["kind"].replace("_", " ")]
            fine = attack.fine
            s = fine.at(laws)
            reached = -np.inf
            for quantity in ours:
                chosen = np.isin(fine.kind, quantity.kinds) if quantity.kinds else fine.theta >= 0.0
                own = np.real(quantity.value([row[chosen] for row in s], size))
                reached = max(reached, float(np.max(own)))
            assert reached == pytest.approx(0.0, abs=5e-3), (limit["kind"], key, at)
            compared.append(key)
    assert len(compared) >= 4, compared


def test_an_oscillator_rings_as_the_verifier_says() -> None:
    """By the matrix exponential as by Duhamel's integral, free laws and given ones, run by run."""
    program = [
        {"kind": "rise", "angle_deg": 43.0, "lift_mm": 5.1, "law": {"kind": "cycloidal"}},
        {"kind": "rise", "angle_deg": 71.0, "lift_mm": 8.6, "law": {"kind": "spline"}},
        *NARROW["program"][1:3],
        {"kind": "dwell", "angle_deg": 107.0},
    ]
    limit = {"kind": "residual_vibration", "natural_frequency_hz": 17.9, "damping_ratio": 0.063}
    spec = {**NARROW, "program": program, "limits": [{**limit, "max_mm": 0.21}]}
    attack = Attack(Program(spec, lambda index: np.linspace(0.0, 1.0, 7)))
    at = attack.start(np.random.default_rng(8), None)
    laws, _ = attack.parts(at)
    known = amplitudes(attack.program.placed(laws), attack.program.omega, limit)
    ours = [q.functional for q in attack.quantities if q.functional is not None]
    assert len(ours) == len(known) == 2
    for functional, amplitude in zip(ours, known, strict=True):
        excess, slope = functional(laws)
        most = float(np.max(excess) + 1.0) * 0.21  # a polygon's: up to 1 / cos 3.75° too large
        assert amplitude * (1.0 - 1e-4) <= most <= amplitude * 1.0023
        step = np.cos(np.arange(len(laws)))
        assert slope @ step == pytest.approx(functional(laws + step)[0] - excess, rel=1e-9)


def _reading(limit: dict[str, Any], key: str) -> str:
    if limit["kind"] == "pressure_angle":
        return f"pressure_angle_{key.removesuffix('_deg')}"
    if limit["kind"] == "face_width":
        return f"face_{key.removesuffix('_mm')}"
    return str(limit["kind"])


def test_most_scenes_are_modelled() -> None:
    modelled = [family for family in FAMILIES if is_modelled(random_scene(family, 0))]
    assert len(modelled) > 0.85 * len(FAMILIES)


@pytest.mark.parametrize("follower", [NARROW["follower"], {
    "kind": "oscillating_roller", "roller_radius_mm": 4.1, "arm_mm": 61.0, "sense": "same",
}], ids=["slide", "arm"])  # fmt: skip
def test_where_no_objective_is_named_the_rms_jerk_of_the_answer_is_held(
    follower: dict[str, Any],
) -> None:
    """As sampled, and with the derivatives that it says: in the unit of the wire."""
    program = NARROW["program"]
    if "arm_mm" in follower:
        program = [{k.replace("lift_mm", "lift_deg"): v for k, v in s.items()} for s in program]
    question = {**NARROW, "program": program, "follower": follower}
    proof = {"lower_bound": 1.0, "other_objectives": [{"objective": "rms_jerk", "value": 2.3e5}]}
    held = with_held_jerk(question, {"certificate": proof})
    assert held[HELD] == 2.3e5
    named = {**question, "objective": {"kind": "rms_jerk"}}
    assert with_held_jerk(named, {"certificate": proof}) == named
    attack = Attack(Program(held, lambda index: np.array([0.0, 0.17, 0.41, 0.83, 1.0])))
    laws, _ = attack.parts(attack.start(np.random.default_rng(3), None))
    (quantity,) = (one for one in attack.quantities if one.name == "rms jerk")
    assert quantity.functional is not None
    excess, slope = quantity.functional(laws)
    samples = attack.program.samples(400)
    gaps = np.diff(samples.theta)
    jerk = samples.at(laws)[3] * attack.program.omega**3 / attack.program.unit
    mean = 0.5 * np.sum(gaps * (jerk[1:] ** 2 + jerk[:-1] ** 2)) / (2.0 * np.pi)
    assert (excess[0] + 1.0) * 2.3e5 == pytest.approx(np.sqrt(mean), rel=5e-3)
    step = np.cos(np.arange(len(laws)))
    ahead, behind = (quantity.functional(laws + sign * 1e-4 * step)[0][0] for sign in (1.0, -1.0))
    assert slope[0] @ step == pytest.approx((ahead - behind) / 2e-4, rel=1e-5)
