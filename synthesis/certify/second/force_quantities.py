"""Forces in ball arithmetic, by virtual work of the output link, in the units of the spec's load.

G is a force along a slide or a moment about a pivot. If the follower's material at the contact
moves by w per mm or rad, the contact force N along the unit normal n satisfies N n·w = G; the
torque at the camshaft is G times the derivative of the displacement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from flint import arb, arb_series

from synthesis.catalogue.forces.load import WireLoad
from synthesis.certify.second.ball_arithmetic import degree
from synthesis.certify.second.exact_motion import MotionPiece
from synthesis.certify.second.maximum import Span
from synthesis.certify.second.quantities import LinkState, contact, curvature, dot


@dataclass(frozen=True, eq=False)
class ExactLoad:
    """The load of the follower, as exact numbers.

    Attributes:
        stated: the load as the spec states it. omega: ω [rad/s].
        side: sign of the spring force. has_friction: whether guide friction acts.
    """

    stated: WireLoad
    omega: arb
    side: int
    has_friction: bool

    @property
    def process_lines(self) -> list[tuple[arb, arb, arb, arb]]:
        """The process force as straight lines: from and to [rad], value at the start, slope."""
        turn, points = arb(360), [(arb(a), arb(f)) for a, f in self.stated.points]
        if not points:
            return [(arb(0), 2 * arb.pi(), arb(0), arb(0))]
        # a turn earlier and a turn later, so that every angle of this one lies between two points
        around = [(a + k * turn, f) for k in (-1, 0, 1) for a, f in points]
        unit = degree()
        return [
            (a * unit, b * unit, f, (g - f) / ((b - a) * unit))
            for (a, f), (b, g) in pairwise(around)
            if b > a
        ]

    def split(self, piece: MotionPiece, low: arb, high: arb) -> Iterator[Span]:
        """The parts of a span on which the process force is one straight line."""
        for start, end, value, slope in self.process_lines:
            first = ((start - piece.start) / piece.angle).max(low).mid()
            last = ((end - piece.start) / piece.angle).min(high).mid()
            if first < last or (low == high and first == last):
                yield replace(piece, process=(start, value, slope)), first, last

    def drive(self, displacement: arb_series, piece: MotionPiece, x: arb) -> arb_series:
        """G as a series in the cam angle [N or N m]."""
        assert piece.process is not None
        start, value, slope = piece.process
        stated, rate = self.stated, displacement.derivative()
        process = arb_series([value + slope * (piece.angle_at(x) - start), slope])
        metre = arb(1) if stated.metre == 1.0 else arb(1) / 1000
        inertia = rate.derivative() * (arb(stated.mass) * self.omega**2 * metre)
        damping = rate * (arb(stated.damping) * self.omega * metre)
        constant = self.side * arb(stated.preload) + arb(stated.weight)
        return inertia + damping + displacement * arb(stated.rate) + process + constant


def contact_force(state: LinkState, path: str) -> arb_series:
    """N, positive along the outward normal [N]."""
    assert state.drive is not None
    touching = contact(state, path)
    n, w = touching.normal(), state.motion_at(touching.curve())
    metre = 1 if state.link.pivot is None else 1000  # N m over mm
    found: arb_series = state.drive * metre * dot(n, n).sqrt() / dot(n, w)
    return found


def camshaft_torque(state: LinkState, path: str) -> arb_series:
    """T [N m]."""
    assert state.drive is not None
    work: arb_series = state.drive * state.displacement.derivative()
    return work if state.link.pivot is not None else work / 1000


def pressure_square(state: LinkState, path: str) -> arb_series:
    """Square of the Hertzian pressure times the compliance of the line contact [N/mm].

    It is the contact force times the sum of both curvatures.
    """
    flank, touching = state.flank, contact(state, path)
    assert flank is not None
    force = contact_force(state, path) * flank.side
    bend = curvature(state, path) * flank.side
    found: arb_series = (
        force / touching.radius()
        if state.link.face is not None
        else force * (bend / (1 - bend * arb(flank.distance)) + 1 / arb(flank.roller))
    )
    return found


FORCES: dict[str, Callable[[LinkState, str], arb_series]] = {
    "contact_force": contact_force,
    "camshaft_torque": camshaft_torque,
    "pressure_square": pressure_square,
}
"""By the names that claims use."""
