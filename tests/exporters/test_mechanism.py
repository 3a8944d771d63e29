"""The machine in motion: rollers roll without slip, links stay rigid, contacts lie on the cam."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from synthesis.design.design import Design
from synthesis.exporters.figures.mechanism import Contact, Mechanism
from synthesis.exporters.samples.cam import Cam
from synthesis.pipeline.assembly import design
from synthesis.studies.analyse import given_cam
from tests.catalogue.followers.samples import CASES, spec

COUNT = 3600
CAMS = pytest.mark.parametrize(("kind", "sample"), CASES, ids=lambda v: str(v))
ROLLERS = pytest.mark.parametrize(
    ("kind", "sample"),
    [case for case in CASES if getattr(spec(*case).follower, "roller_radius_mm", 0.0) > 0.0],
    ids=lambda v: str(v),
)
Points = np.ndarray  # complex, (n,)


def drawn_cam(kind: str, sample: int, **changes: object) -> Design:
    """A given cam as a design: nothing is solved and nothing certified."""
    question = spec(kind, sample, **changes)
    return design(question, given_cam(question), [], [], [], 0.0, None)


@cache
def machine_of(kind: str, sample: int) -> Mechanism:
    return Mechanism.of(Cam.of(drawn_cam(kind, sample)), COUNT)


def turned(machine: Mechanism) -> np.ndarray:
    """Angle of the link, (n,)."""
    return np.zeros(COUNT + 1) if machine.pivot is None else machine.moved


def carried(machine: Mechanism, point: Points) -> Points:
    """Points of the link at displacement 0, as they are moved with it."""
    if machine.slide is not None:
        return point + machine.moved * machine.slide
    return machine.pivot + np.exp(1j * machine.moved) * (point - machine.pivot)


def traced(machine: Mechanism, contact: Contact) -> Points:
    there = contact.place + contact.along * np.exp(1j * contact.heading)
    return carried(machine, there)


def rate(values: np.ndarray) -> np.ndarray:
    """Central differences per radian, (n − 2,)."""
    return (values[2:] - values[:-2]) / (4.0 * np.pi / COUNT)


@CAMS
def test_contacts_lie_on_the_cam_and_turn_with_it(kind: str, sample: int) -> None:
    machine = machine_of(kind, sample)
    for contact in machine.contacts:
        normal = np.exp(1j * (contact.normal + turned(machine)))
        gap = contact.flank.side * contact.flank.distance
        touch = (traced(machine, contact) - gap * normal) * np.exp(-1j * machine.theta)
        assert np.max(np.abs(touch - (contact.curve.x + 1j * contact.curve.y))) < 1e-9
        drive = np.exp(1j * (contact.drive + turned(machine)))
        angle = np.angle(normal / drive)
        assert np.max(np.abs(angle - contact.curve.pressure_angle)) < 1e-9
        # as the follower really moves where it does
        moving = np.abs(rate(machine.moved)) > 0.05 * np.max(np.abs(rate(machine.moved)))
        if contact.roller > 0.0:
            way = rate(traced(machine, contact))[moving]
            across = np.abs(np.imag(way / drive[1:-1][moving]))
            assert np.max(across / np.abs(way)) < 1e-3


@ROLLERS
def test_rollers_roll_without_slip(kind: str, sample: int) -> None:
    machine = machine_of(kind, sample)
    assert all(each.roller > 0.0 for each in machine.contacts)
    for contact in machine.contacts:
        centre, spin = traced(machine, contact), contact.roll + turned(machine)
        normal = np.exp(1j * (contact.normal + turned(machine)))
        touch = centre - contact.flank.side * contact.roller * normal
        of_cam = 1j * touch[1:-1]
        of_roller = rate(centre) + 1j * rate(spin) * (touch - centre)[1:-1]
        slip = np.abs(of_cam - of_roller)
        assert np.max(slip) < 2e-3 * np.max(np.abs(of_cam))
        assert np.median(slip) < 1e-5 * np.max(np.abs(of_cam))


@ROLLERS
def test_the_roller_unrolls_the_length_of_the_profile(kind: str, sample: int) -> None:
    machine = machine_of(kind, sample)
    contacts = [each for each in machine.contacts if each.flank.distance == each.roller]
    assert len(contacts) == len(machine.contacts) or getattr(
        spec(kind, sample).follower.closure, "clearance_mm", 0.0
    )
    for contact in contacts:
        outline = contact.curve.x + 1j * contact.curve.y
        length = float(np.sum(np.abs(np.diff(outline))))
        on_roller = (contact.normal - contact.roll)[[0, -1]]
        unrolled = contact.roller * abs(float(np.diff(on_roller)[0]))
        assert unrolled == pytest.approx(length, rel=1e-5)


def test_roller_on_a_circle_is_two_gears() -> None:
    """On a dwell a roller turns by −Rb/Rr of the cam's angle, inside a ring by +."""
    for sample, inside in ((0, False), (2, True)):
        machine = machine_of("translating_roller", sample)
        contact = machine.contacts[0]
        still = np.flatnonzero(np.abs(np.diff(machine.s)) < 1e-12)
        k = still[len(still) // 2]
        ratio = (contact.roll[k + 1] - contact.roll[k]) / (machine.theta[1] - machine.theta[0])
        radius = float(np.hypot(contact.curve.x[k], contact.curve.y[k]))
        want = radius / contact.roller * (1.0 if inside else -1.0)
        assert ratio == pytest.approx(want, rel=1e-9)
