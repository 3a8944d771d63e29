"""Speed and acceleration of rollers, and sliding of faces, by another route, to 1e-9.

Velocities of material points, in power series about each cam angle ("jets"): of the product only
the output link at rest and the motion law's name are used. No traced curve, no tangent and no
curvature occurs.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from synthesis.catalogue.followers.kinematics import Flank, Link
from synthesis.units import DEGREE
from tests.certify.test_cam_geometry import ARM, FACE, RISE_RETURN, SWING, TURN, designed, roller

OMEGA = 300.0 * TURN / 60.0
ORDER = 2  # of the series: derivatives of the displacement up to this one
SAMPLES = 801  # of a part of a law, and of what lies beside the largest of them, twice


@dataclass(frozen=True)
class Jet:
    """Coefficients (ORDER + 1, n) of a power series in the cam angle about n angles; complex."""

    c: np.ndarray

    def __add__(self, other) -> "Jet":
        return Jet(self.c + _jet(other, self).c)

    def __sub__(self, other) -> "Jet":
        return Jet(self.c - _jet(other, self).c)

    def __mul__(self, other) -> "Jet":
        a, b = self.c, _jet(other, self).c
        return Jet(np.stack([sum(a[k] * b[n - k] for k in range(n + 1)) for n in range(len(a))]))

    def rate(self) -> "Jet":
        """The derivative by the cam angle; its last coefficient is not known and is left 0."""
        n = np.arange(1, len(self.c))[:, None]
        return Jet(np.concatenate([self.c[1:] * n, np.zeros_like(self.c[:1])]))

    def part(self, unit: "Jet") -> "Jet":
        """The component along a unit vector."""
        return Jet((self * Jet(unit.c.conj())).c.real.astype(complex))

    def length(self) -> "Jet":
        """|·| by l² = |·|²: l0 = √, then l_n = (q_n − Σ l_k l_{n−k})/2 l0."""
        q = (self * Jet(self.c.conj())).c.real
        found = [np.sqrt(q[0])]
        for n in range(1, len(q)):
            inner = sum(found[k] * found[n - k] for k in range(1, n))
            found.append((q[n] - inner) / (2.0 * found[0]))
        return Jet(np.array(found).astype(complex))


def _jet(value, like: Jet) -> Jet:
    if isinstance(value, Jet):
        return value
    constant = np.zeros_like(like.c)
    constant[0] = value
    return Jet(constant)


def turning(angle: Jet, factor: float) -> Jet:
    """exp(i · factor · angle): e_n = i factor/n Σ k a_k e_{n−k}."""
    a, e = angle.c * (1j * factor), [np.exp(angle.c[0] * 1j * factor)]
    for n in range(1, len(a)):
        e.append(sum(k * a[k] * e[n - k] for k in range(1, n + 1)) / n)
    return Jet(np.array(e))


def travel(program, angle_deg: np.ndarray, index: int) -> Jet:
    """The displacement of a segment of ``RISE_RETURN`` or ``SWING``, from its law's formula."""
    start = sum(s["angle_deg"] for s in program[:index])
    level = lift = 0.0
    for segment in program[: index + 1]:
        level += lift
        lift = next((v for k, v in segment.items() if k.startswith("lift")), 0.0)
        lift *= {"rise": 1.0, "dwell": 0.0, "return": -1.0}[segment["kind"]]
    beta = program[index]["angle_deg"]
    x = Jet(np.zeros((ORDER + 1, len(angle_deg)), dtype=complex))
    x.c[0], x.c[1] = (angle_deg - start) / beta, 1.0 / (beta * DEGREE)
    return law(program[index].get("law", {}).get("kind"), x) * lift + level


def law(kind: str | None, x: Jet) -> Jet:
    if kind == "polynomial_3_4_5":
        return x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
    if kind == "modified_sine":
        # Norton: an eighth of a sinusoid of period 1/2, the middle one of period 3/2
        middle = (x.c[0].real >= 0.125) & (x.c[0].real <= 0.875)
        last = x.c[0].real > 0.875
        a = math.pi / (4.0 + math.pi)

        def sine(factor: float, phase: float) -> Jet:
            wave = turning(x, factor) * np.exp(1j * phase)
            return Jet(wave.c - turning(x, -factor).c * np.exp(-1j * phase)) * (-0.5j)

        outer = x * a - sine(4.0 * math.pi, 0.0) * (0.25 * a / math.pi)
        outer = Jet(outer.c + np.where(last, _jet(4.0 * a / math.pi, x).c, 0.0))
        inner = x * a - sine(4.0 * math.pi / 3.0, math.pi / 3.0) * (2.25 * a / math.pi)
        inner = inner + 2.0 * a / math.pi
        return Jet(np.where(middle, inner.c, outer.c))
    return x * 0.0


def vector(pair) -> complex:
    return complex(float(pair[0]), float(pair[1]))


def spin(link: Link, s: Jet, flank: Flank) -> Jet:
    """Turning of the roller on its pin, per radian of cam angle, counter-clockwise positive."""
    at = next(vector(tip.at) for tip in link.tips if tip.path == flank.path)
    turn = _jet(0.0, s)
    if link.slide is not None:
        moved = s * vector(link.slide) + at
    else:
        pivot = vector(link.pivot)
        moved = turning(s, link.turn * DEGREE) * (at - pivot) + pivot
        turn = s.rate() * (link.turn * DEGREE)
    # the centre moves past the cam's material, which has the velocity i p; the roller touches the
    # cam square to that, on the side of the axis or, in a ring, on the far one
    past = moved.rate() - moved * 1j
    unit = divided(past, past.length())
    outward = unit * 1j  # the centre runs clockwise round the cam
    contact = moved - outward * (flank.side * flank.roller)
    # the roller's rim and the cam move alike there: C' + i Ω (contact − C) = i contact along t
    rim = (contact - moved) * 1j
    left = (contact * 1j - moved.rate()).part(unit)
    return divided(left, rim.part(unit)) - turn


def divided(a: Jet, b: Jet) -> Jet:
    found: list[np.ndarray] = []
    for n in range(len(a.c)):
        inner = sum(found[k] * b.c[n - k] for k in range(n))
        found.append((a.c[n] - inner) / b.c[0])
    return Jet(np.array(found))


def sliding(link: Link, s: Jet) -> Jet:
    """Speed of the face past the cam where it touches, per radian of cam angle."""
    base, along = vector(link.face.at), vector(link.face.along)
    normal = vector(link.face.normal)
    if link.slide is not None:
        moved, swing, turn = s * vector(link.slide) + base, _jet(1.0, s), _jet(0.0, s)
        origin = s * vector(link.slide)
    else:
        pivot, swing = vector(link.pivot), turning(s, link.turn * DEGREE)
        moved, turn = swing * (base - pivot) + pivot, s.rate() * (link.turn * DEGREE)
        origin = _jet(pivot, s)
    e, n = swing * along, swing * normal

    def past(p: Jet) -> Jet:  # how fast the face's material at p moves past the cam's, i p
        return origin.rate() + (p - origin) * turn * 1j - p * 1j

    # contact is where it has no component across the face; that is linear along the face
    at0, at1 = past(moved).part(n), past(moved + e).part(n)
    reach = divided(at0, at0 - at1)
    return past(moved + e * reach).part(e)


def largest(program, function, order: int) -> float:
    """The largest |derivative| over the turn: on samples of every part of a law, then beside."""
    best, start = 0.0, 0.0
    for index, segment in enumerate(program):
        beta = segment["angle_deg"]
        shares = [0.0, 0.125, 0.875, 1.0]
        for low, high in pairwise(shares):
            ends = start + beta * (low + 1e-13), start + beta * (high - 1e-13)
            for _ in range(3):
                angle = np.linspace(*ends, SAMPLES)
                values = np.abs(function(travel(program, angle, index)).c[order].real)
                top, step = int(values.argmax()), angle[1] - angle[0]
                ends = max(ends[0], angle[top] - step), min(ends[1], angle[top] + step)
            best = max(best, float(values.max()))
        start += beta
    return best * OMEGA ** (order + 1)


RING = {"kind": "force", "contact": "inside", "rim_mm": 6.0}
CONJUGATE = {"kind": "conjugate", "roller_radius_mm": 10.0, "arm_mm": 85.0}
GROOVE = {"kind": "groove", "clearance_mm": 0.1, "rim_mm": 8.0}


@pytest.mark.parametrize(
    ("follower", "program", "base"),
    [
        (roller(), RISE_RETURN, 40.0),
        (roller(offset_mm=-4.0, closure=RING), RISE_RETURN, 40.0),
        (ARM, SWING, 30.0),
        ({**ARM, "sense": "same"}, SWING, 30.0),
        ({**ARM, "closure": RING}, SWING, 40.0),
        (roller(closure=GROOVE), RISE_RETURN, 40.0),
        ({**ARM, "closure": CONJUGATE}, SWING, 40.0),
    ],
)
def test_a_roller_turns_as_rims_that_do_not_slip(follower, program, base):
    design = designed(follower, base, program)
    link = design.completed_spec.follower.link(tuple(design.size), DEGREE)
    flanks = design.completed_spec.follower.flanks
    for found, flank in zip(design.geometry.flanks, flanks, strict=True):
        speed, rate = (
            largest(program, lambda s, flank=flank: spin(link, s, flank), order) for order in (0, 1)
        )
        assert found.roller_speed_rpm.value * TURN / 60.0 == pytest.approx(speed, rel=1e-9)
        assert found.roller_acceleration_rad_per_s2.value == pytest.approx(rate, rel=1e-9)


SLIDING = {"kind": "slide", "moving_mass_kg": 1.0,
           "spring": {"rate_n_per_mm": 5.0, "preload_n": 200.0}}  # fmt: skip
SWINGING = {"kind": "arm", "moment_of_inertia_kg_m2": 0.01,
            "spring": {"rate_n_m_per_rad": 5.0, "preload_n_m": 20.0}}  # fmt: skip


@pytest.mark.parametrize(
    ("follower", "program", "load"), [(roller(), RISE_RETURN, SLIDING), (ARM, SWING, SWINGING)]
)
def test_the_forces_know_the_same_largest_speed(follower, program, load):
    design = designed(follower, 35.0, program, load=load)
    link = design.completed_spec.follower.link(tuple(design.size), DEGREE)
    (flank,), (found,) = design.completed_spec.follower.flanks, design.forces.rollers
    speed = largest(program, lambda s: spin(link, s, flank), 0)
    assert found.largest_speed_rpm * TURN / 60.0 == pytest.approx(speed, rel=1e-9)


@pytest.mark.parametrize(
    ("face", "program"),
    [
        ({"kind": "translating_flat_face"}, RISE_RETURN),
        ({"kind": "translating_flat_face", "tilt_deg": 12.0, "offset_mm": 3.0}, RISE_RETURN),
        (FACE, SWING),
        ({**FACE, "sense": "same"}, SWING),
        ({**FACE, "pivot_direction_deg": 71.0}, SWING),
    ],
)
def test_a_face_slides_past_the_cams_material(face, program):
    design = designed(face, 40.0, program)
    (flank,) = design.geometry.flanks
    link = design.completed_spec.follower.link(tuple(design.size), DEGREE)
    speed = largest(program, lambda s: sliding(link, s), 0)
    assert flank.sliding_speed_mm_per_s.value == pytest.approx(speed, rel=1e-9)
