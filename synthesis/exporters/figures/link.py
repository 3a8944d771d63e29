"""What the machine's link is drawn as: stem, arms or plate, and its rollers (y upwards, mm)."""

from __future__ import annotations

import math

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.mechanism import Contact, Mechanism
from synthesis.exporters.figures.parts import HUB, bar, half_width, point_from
from synthesis.units import DEGREE

GUIDE, OVER = (4.0, 12.0), 2.0  # of a slide, in units: from and to above its highest place; more
SPOKES = (0.0, 60.0, 120.0)


def stem_length(machine: Mechanism, u: float) -> float:
    """From a slide's roller or face to the end of its stem, through the guide [mm]."""
    roller = machine.contacts[0].roller
    return roller + float(machine.moved.max()) + (GUIDE[1] + OVER) * u


def face_ends(contact: Contact, machine: Mechanism, u: float) -> tuple[float, float]:
    """From where to where a face is drawn [mm]: as far as contact needs it; on a pivot from it."""
    low, high = float(contact.along.min()), float(contact.along.max())
    if machine.link.pivot is not None:
        return min(low, 0.0), max(high, 0.0)
    return min(low, -1.5 * u), max(high, 1.5 * u)


def holders(machine: Mechanism, u: float) -> list[str]:
    """Stem or arms of the rollers, and what joins two of them on one slide."""
    link, first = machine.link, machine.contacts[0]
    if link.pivot is not None:
        pivot = float(link.pivot[0]), float(link.pivot[1])
        return [edge for one in machine.contacts for edge in bar(one.place, pivot, one.roller, u)]
    assert link.slide is not None
    up, half = (float(link.slide[0]), float(link.slide[1])), half_width(first.roller, u)
    foot = math.sqrt(max(first.roller**2 - half**2, 0.0)) if first.roller else 3.0 * half
    length = stem_length(machine, u)
    corners = [(length, -half), (foot, -half), (foot, half), (length, half)]
    steps = "L".join(point_from(first.place, up, *corner) for corner in corners)
    body = [svg.path("outline metal", f"M{steps}Z")]
    if first.roller == 0.0:
        corners = [(foot, -half), (0.0, 0.0), (foot, half)]
        steps = "L".join(point_from(first.place, up, *corner) for corner in corners)
        body.append(svg.path("outline metal", f"M{steps}"))
    joined = [svg.line("line axis", *first.place, *one.place) for one in machine.contacts[1:]]
    return [*joined, *body]


def plate(machine: Mechanism, u: float) -> list[str]:
    """The plate, and its stem or the link to its pivot."""
    face, link, contact = machine.face, machine.link, machine.contacts[0]
    assert face is not None
    normal = float(face.normal[0]), float(face.normal[1])
    low, high = face_ends(contact, machine, u)
    right = 1.0 if normal[1] * face.along[0] - normal[0] * face.along[1] > 0.0 else -1.0
    corners = [(0.0, low), (0.0, high), (2.0 * u, high), (2.0 * u, low)]
    steps = "L".join(point_from(contact.place, normal, a, right * b) for a, b in corners)
    body = svg.path("outline metal", f"M{steps}Z")
    if link.pivot is not None:
        pivot = float(link.pivot[0]), float(link.pivot[1])
        return [svg.line("line outline", *contact.place, *pivot), body]
    assert link.slide is not None
    up, half = (float(link.slide[0]), float(link.slide[1])), half_width(0.0, u)
    length = stem_length(machine, u)
    ends = [(length, -half), (0.0, -half), (0.0, half), (length, half)]
    steps = "L".join(point_from(contact.place, up, *corner) for corner in ends)
    return [svg.path("outline metal", f"M{steps}Z"), body]


def wheel(radius: float, u: float) -> list[str]:
    """A roller with spokes, one of them marked, so that it is seen to turn."""
    if radius == 0.0:
        return []
    hub = min(0.2 * radius, 2.0 * HUB * u)
    spokes = [
        svg.line("line axis", -a * radius, -b * radius, a * radius, b * radius)
        for a, b in ((math.cos(t * DEGREE), math.sin(t * DEGREE)) for t in SPOKES)
    ]
    return [svg.circle("outline glass", 0.0, 0.0, radius), *spokes,
            svg.circle("outline metal", 0.0, 0.0, hub),
            svg.circle("solid", 0.0, 0.72 * radius, min(0.12 * radius, 1.2 * u))]  # fmt: skip
