"""Forces in balls: from virtual work of the bare mechanism, in the units in which the load is told.

G is a force along a slide or a moment about a pivot. The material of the follower at the contact
moves by w per mm or rad, so N n·w = G; the shaft's torque is G times the rate of the displacement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from flint import arb, arb_series

from synthesis.confirmation.arithmetic import degree
from synthesis.confirmation.course import Piece
from synthesis.confirmation.quantities import View, contact, curvature, dot
from synthesis.confirmation.search import Span
from synthesis.forces.load import AsTold


@dataclass(frozen=True, eq=False)
class Burden:
    """What loads the follower, as exact numbers.

    Attributes:
        told: as on the wire. omega: ω [rad/s]. side: σ of the spring. rubs: with friction.
    """

    told: AsTold
    omega: arb
    side: int
    rubs: bool

    @property
    def lines(self) -> list[tuple[arb, arb, arb, arb]]:
        """The process force as straight lines: from and to [rad], value at the beginning, slope."""
        turn, points = arb(360), [(arb(a), arb(f)) for a, f in self.told.points]
        if not points:
            return [(arb(0), 2 * arb.pi(), arb(0), arb(0))]
        # a turn earlier and a turn later, so that the whole of this one lies between
        around = [(a + k * turn, f) for k in (-1, 0, 1) for a, f in points]
        unit = degree()
        return [
            (a * unit, b * unit, f, (g - f) / ((b - a) * unit))
            for (a, f), (b, g) in pairwise(around)
            if b > a
        ]

    def cut(self, piece: Piece, low: arb, high: arb) -> Iterator[Span]:
        """The parts of a span on which the process force is one straight line."""
        for start, end, value, slope in self.lines:
            first = ((start - piece.start) / piece.angle).max(low).mid()
            last = ((end - piece.start) / piece.angle).min(high).mid()
            if first < last or (low == high and first == last):
                yield replace(piece, process=(start, value, slope)), first, last

    def drive(self, moved: arb_series, piece: Piece, x: arb) -> arb_series:
        """G as a series in the cam angle [N, or N m]."""
        assert piece.process is not None
        start, value, slope = piece.process
        told, rate = self.told, moved.derivative()
        process = arb_series([value + slope * (piece.angle_at(x) - start), slope])
        metre = arb(1) if told.metre == 1.0 else arb(1) / 1000
        inertia = rate.derivative() * (arb(told.mass) * self.omega**2 * metre)
        damping = rate * (arb(told.damping) * self.omega * metre)
        still = self.side * arb(told.preload) + arb(told.weight)
        return inertia + damping + moved * arb(told.rate) + process + still


def contact_force(view: View, path: str) -> arb_series:
    """N, positive where it pushes the way of the outward normal [N]."""
    assert view.drive is not None
    touching = contact(view, path)
    n, w = touching.normal(), view.driven(touching.curve())
    metre = 1 if view.link.pivot is None else 1000  # N m over mm
    found: arb_series = view.drive * metre * dot(n, n).sqrt() / dot(n, w)
    return found


def camshaft_torque(view: View, path: str) -> arb_series:
    """T [N m]."""
    assert view.drive is not None
    work: arb_series = view.drive * view.moved.derivative()
    return work if view.link.pivot is not None else work / 1000


def pressure_square(view: View, path: str) -> arb_series:
    """p² times the stiffness of the line contact: force times the curvatures' sum [N/mm]."""
    flank, touching = view.flank, contact(view, path)
    assert flank is not None
    force = contact_force(view, path) * flank.side
    bend = curvature(view, path) * flank.side
    found: arb_series = (
        force / touching.radius()
        if view.link.face is not None
        else force * (bend / (1 - bend * arb(flank.distance)) + 1 / arb(flank.roller))
    )
    return found


FORCES: dict[str, Callable[[View, str], arb_series]] = {
    "contact_force": contact_force,
    "camshaft_torque": camshaft_torque,
    "pressure_square": pressure_square,
}
"""By the names that claims know."""
