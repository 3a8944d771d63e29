"""Diagrams of forces: contact force and Hertz pressure of every flank, torque on the camshaft."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.limits import Claim
from synthesis.design.design import Design
from synthesis.exporters.diagrams.motion import MEASURED_PER_DEGREE
from synthesis.exporters.diagrams.plot import NOWHERE, Plot
from synthesis.exporters.diagrams.readings import Bound, Ends, Trace, claimed
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import ForceSamples


def force_plots(design: Design, cam: Cam) -> Iterator[Plot]:
    """The diagrams of a design's forces; none where the spec has no load."""
    drawn, fine = (
        ForceSamples.of(design, cam, MotionOptions(density))
        for density in (DRAWN_PER_DEGREE, MEASURED_PER_DEGREE)
    )
    if drawn is None or fine is None:
        return
    samples = drawn, fine

    def plot(
        title: str, unit: str, limits: Sequence[Bound], name: str, flank: str | None = None
    ) -> Plot:
        curve, fine = (
            Trace(each.rows.degrees, each.rows.side, each.value(name, flank)) for each in samples
        )
        return Plot(f"{title} {flank or ''}".strip(), unit, curve, fine, NOWHERE, limits)

    for flank in fine.right.contact:
        limits = _limits(design, "contact_force", labelled("contact_force", flank))
        yield plot("Contact force N", "N", limits, "contact", flank)
    for flank in fine.right.pressure:
        limits = _limits(design, "pressure_square", labelled("hertz_pressure", flank))
        yield plot("Hertz pressure p", "MPa", limits, "pressure", flank)
    limits = _limits(design, "camshaft_torque", "camshaft_torque")
    yield plot("Camshaft torque T", "N m", limits, "torque")


def _limits(design: Design, quantity: str, name: str) -> list[Bound]:
    """The bounds of a flank's claims, in the unit of the spec."""

    def ours(claim: Claim) -> bool:
        whole = claim.limit.removesuffix("_min").removesuffix("_max")
        return claim.quantity == quantity and whole == name

    def ends(claim: Claim) -> Ends:
        low, high = (
            None if end is None else claim.to_wire(end) for end in (claim.lower, claim.upper)
        )
        falls = (claim.to_wire(1.0) or 0.0) < (claim.to_wire(-1.0) or 0.0)
        return (high, low) if falls else (low, high)

    return claimed(design, ours, ends)
