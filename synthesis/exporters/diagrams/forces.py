"""Diagrams of forces: contact force and Hertz pressure of every flank, torque on the camshaft."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.limits import Claim
from synthesis.design.design import Design
from synthesis.exporters.diagrams.motion import MEASURED_PER_DEGREE
from synthesis.exporters.diagrams.plot import NOWHERE, Plot
from synthesis.exporters.diagrams.readings import Bound, Ends, Trace, claimed
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.carried import Carried, carried
from synthesis.numerics.piecewise import Array

Values = Callable[[Carried], Array]


def force_plots(design: Design, cam: Cam) -> Iterator[Plot]:
    """The diagrams of a design's forces; none where no load is told."""
    drawn, fine = (
        carried(design, cam, MotionOptions(density))
        for density in (DRAWN_PER_DEGREE, MEASURED_PER_DEGREE)
    )
    if drawn is None or fine is None:
        return
    both = drawn, fine
    for name in fine.right.contact:
        limits = _limits(design, "contact_force", labelled("contact_force", name))
        yield _plot(_titled("Contact force N", name), "N", both, _force(name), limits)
    for name in fine.right.pressure:
        limits = _limits(design, "pressure_square", labelled("hertz_pressure", name))
        yield _plot(_titled("Hertz pressure p", name), "MPa", both, _pressure(name), limits)
    limits = _limits(design, "camshaft_torque", "camshaft_torque")
    yield _plot("Camshaft torque T", "N m", both, lambda found: found.torque, limits)


def _titled(title: str, flank: str) -> str:
    return " ".join(filter(None, (title, flank)))


def _force(flank: str) -> Values:
    return lambda found: dict(found.contact())[flank]


def _pressure(flank: str) -> Values:
    return lambda found: dict(found.pressure())[flank]


def _plot(
    title: str, unit: str, both: tuple[Carried, Carried], values: Values, limits: Sequence[Bound]
) -> Plot:
    curve, fine = (Trace(each.rows.degrees, each.rows.side, values(each)) for each in both)
    return Plot(title=title, unit=unit, curve=curve, fine=fine, infinite=NOWHERE, limits=limits)


def _limits(design: Design, quantity: str, name: str) -> list[Bound]:
    """The bounds of a flank's claims, as they were asked for."""

    def ours(claim: Claim) -> bool:
        whole = claim.limit.removesuffix("_min").removesuffix("_max")
        return claim.quantity == quantity and whole == name

    def ends(claim: Claim) -> Ends:
        told = [None if end is None else claim.to_wire(end) for end in (claim.lower, claim.upper)]
        known = [end for end in told if end is not None]
        falls = (claim.to_wire(1.0) or 0.0) < (claim.to_wire(-1.0) or 0.0)
        low, high = told[::-1] if falls else told
        return (low, high) if known else (None, None)

    return claimed(design, ours, ends)
