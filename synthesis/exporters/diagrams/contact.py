"""Diagrams of the contact as SVG, over the cam angle (mm).

Pressure angle of every roller's path, profile radius of every flank; with a load contact force and
Hertz pressure of every flank, and torque on the camshaft. The radius has the flank's sign: convex
positive, hollow negative, as its material sees it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from synthesis.catalogue.followers.base import flat_face
from synthesis.catalogue.followers.kinematics import labelled
from synthesis.catalogue.limits import Claim
from synthesis.catalogue.profile import CamProfile
from synthesis.design.design import Design
from synthesis.exporters.diagrams.motion import MEASURED_PER_DEGREE
from synthesis.exporters.diagrams.plot import NOWHERE, Bound, Plot, Trace, claimed_bounds, radii
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE, sheet
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import MotionOptions, PictureOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import ForceSamples
from synthesis.exporters.samples.sampling import in_degrees, table_rows
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DENSITIES = MotionOptions(DRAWN_PER_DEGREE), MotionOptions(MEASURED_PER_DEGREE)


def _contact(design: Design, options: PictureOptions) -> bytes:
    cams = tuple(Cam.of(design).flanks())
    ways = {cam.flank.path: cam for cam in reversed(cams)}
    plots = [pressure_plot(design, ways[path]) for path in reversed(ways)]
    plots += [radius_plot(design, cam) for cam in cams]
    forces = list(force_plots(design, cams[0]))
    title = f"Contact of {design.name or design.id}"
    text = "Pressure angle and radius of curvature of the profile over the cam angle."
    if forces:
        text = f"{text[:-1]}, contact force and torque."
    return sheet(design, [*plots, *forces], title, text, options.theme)


def pressure_plot(design: Design, cam: Cam) -> Plot:
    """The pressure angle along the traced curve of a flank."""
    path = cam.flank.path
    curve, fine = _traces(cam, lambda at: at.pressure_angle / DEGREE)
    limits = claimed_bounds(
        design,
        lambda claim: claim.quantity == "pressure_angle" and claim.path == path,
        lambda _, value: value / DEGREE,
    )
    return Plot(f"Pressure angle α {path}".strip(), "°", curve, fine, NOWHERE, limits)


def radius_plot(design: Design, cam: Cam) -> Plot:
    """The radius of curvature of a flank: even in curvature, along a flat face in the radius."""
    name, side, distance = cam.flank.name, cam.flank.side, cam.flank.distance
    wanted = {labelled(limit, name) for limit in ("profile_radius", "cutter_radius")}
    limits = claimed_bounds(
        design, lambda claim: claim.limit in wanted, lambda _, value: side * value
    )
    theta = cam.joints.breaking(1)
    if flat_face(cam.follower) is not None:
        # Along a face nothing can be hollow. Where the velocity jumps the face rocks on a corner,
        # or would have to leave the cam.
        left, right = (cam.motion.derivatives(theta, 3, side) for side in ("left", "right"))
        curve, fine = _traces(cam, lambda at: at.radius)
        plot = Plot(f"Profile radius ρ {name}".strip(), "mm", curve, fine, NOWHERE, limits)
        infinite = Trace.infinite(in_degrees(theta), right[1] - left[1])
        ends = ("min", False), ("max", True)
        return replace(plot, infinite=infinite, ends=ends, bad=(-np.inf, 0.0))
    curve, fine = _traces(cam, lambda at: side * at.curvature)
    # A corner of the traced curve is infinitely convex or hollow, as the material sees it; the
    # curve of a ccw cam runs clockwise.
    before, after = cam.at(theta, np.ones(len(theta), dtype=bool)), cam.at(theta)
    turn = before.normal_x * after.normal_y - before.normal_y * after.normal_x
    mirror = 1.0 if cam.rotation == "ccw" else -1.0
    convex = [("convex", True)] if fine.values.max() > 0.0 else []
    hollow = [("hollow", False)] if fine.values.min() < 0.0 else []
    return Plot(
        f"Profile radius ρ {name}".strip(), "mm", curve, fine,
        infinite=Trace.infinite(in_degrees(theta), -mirror * side * turn),
        limits=limits,
        ends=convex + hollow,
        labels=radii(distance),
        bad=(1.0 / distance, np.inf) if distance > 0.0 else (),
    )  # fmt: skip


def _traces(cam: Cam, value: Callable[[CamProfile], Array]) -> Iterator[Trace]:
    """As it is drawn, and as its extremes are read."""
    for density in DENSITIES:
        rows = table_rows(cam, density)
        yield Trace(rows.degrees, rows.side, value(cam.at(rows.theta, rows.left)))


def force_plots(design: Design, cam: Cam) -> Iterator[Plot]:
    """The diagrams of a design's forces; none where the spec has no load."""
    drawn, fine = (ForceSamples.of(design, cam, density) for density in DENSITIES)
    if drawn is None or fine is None:
        return
    samples = drawn, fine

    def plot(
        title: str, unit: str, limits: list[Bound], name: str, flank: str | None = None
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

    return claimed_bounds(design, ours)


CONTACT = Exporter(
    "contact.svg", "Pressure angle and profile radius", "image/svg+xml", ".svg", _contact,
    PictureOptions, "Diagrams over the cam angle, of every roller's path and every flank; with a "
    "load contact force, Hertz pressure and torque, too.",
)  # fmt: skip
