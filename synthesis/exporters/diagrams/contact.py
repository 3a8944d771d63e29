"""Diagrams of the contact as SVG: pressure angle and profile radius over the cam angle (mm).

One of each for every roller's path and every flank. The radius has the flank's sign: convex
positive, hollow negative, as its material sees it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from synthesis.catalogue.followers.base import flat_face
from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.limits import Claim
from synthesis.catalogue.profile import CamProfile
from synthesis.design.design import Design
from synthesis.exporters.diagrams.forces import force_plots
from synthesis.exporters.diagrams.motion import MEASURED_PER_DEGREE
from synthesis.exporters.diagrams.plot import NOWHERE, Plot, radii
from synthesis.exporters.diagrams.readings import Bound, Ends, Trace, claimed
from synthesis.exporters.diagrams.sheet import DRAWN_PER_DEGREE, sheet
from synthesis.exporters.drawing.picture_options import PictureOptions
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import in_degrees, table_rows
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

DRAWN, MEASURED = MotionOptions(DRAWN_PER_DEGREE), MotionOptions(MEASURED_PER_DEGREE)
LIMITS = ("profile_radius", "cutter_radius")


def _contact(design: Design, options: PictureOptions) -> bytes:
    cams = tuple(Cam.of(design).flanks())
    ways = {cam.flank.path: cam for cam in reversed(cams)}
    plots = [pressure_plot(design, ways[path]) for path in reversed(ways)]
    plots += [radius_plot(design, cam) for cam in cams]
    forces = list(force_plots(design, cams[0]))
    title = f"Contact of {design.name or design.id}"
    told = "Pressure angle and radius of curvature of the profile over the cam angle."
    if forces:
        told = f"{told[:-1]}, contact force and torque."
    return sheet(design, [*plots, *forces], title, told, options.theme)


def pressure_plot(design: Design, cam: Cam) -> Plot:
    """The pressure angle along the traced curve of a flank."""
    path = cam.flank.path

    def angle(at: CamProfile) -> Array:
        return at.pressure_angle / DEGREE

    def ours(claim: Claim) -> bool:
        return claim.quantity == "pressure_angle" and claim.path == path

    def ends(claim: Claim) -> Ends:
        lower, upper = claim.lower, claim.upper
        return None if lower is None else lower / DEGREE, None if upper is None else upper / DEGREE

    return Plot(
        title=" ".join(filter(None, ("Pressure angle α", path))),
        unit="°",
        curve=_read(cam, DRAWN, angle),
        fine=_read(cam, MEASURED, angle),
        infinite=NOWHERE,
        limits=claimed(design, ours, ends),
    )


def radius_plot(design: Design, cam: Cam) -> Plot:
    """The radius of curvature of a flank: even in curvature, along a flat face in the radius."""
    name = cam.flank.name
    wanted = {labelled(limit, name) for limit in LIMITS}
    title = " ".join(filter(None, ("Profile radius ρ", name)))
    plot = Plot(title, "mm", NOWHERE, NOWHERE, NOWHERE)
    side, distance = cam.flank.side, cam.flank.distance

    def bend(at: CamProfile) -> Array:
        return side * at.curvature

    def ends(claim: Claim) -> Ends:
        return (claim.lower, claim.upper) if side > 0 else (_less(claim.upper), _less(claim.lower))

    limits = claimed(design, lambda claim: claim.limit in wanted, ends)
    if flat_face(cam.follower) is not None:
        return _faced(plot, cam, limits)
    fine = _read(cam, MEASURED, bend)
    bent = [("convex", True)] if fine.values.max() > 0.0 else []
    hollow = [("hollow", False)] if fine.values.min() < 0.0 else []
    return replace(
        plot,
        curve=_read(cam, DRAWN, bend),
        fine=fine,
        infinite=_corners(cam),
        limits=limits,
        ends=bent + hollow,
        labels=radii(distance),
        bad=(1.0 / distance, np.inf) if distance > 0.0 else (),
    )


def _faced(plot: Plot, cam: Cam, limits: list[Bound]) -> Plot:
    """Along a flat face nothing can be hollow, and the radius itself is finite."""

    def radius(at: CamProfile) -> Array:
        return at.radius

    return replace(
        plot,
        curve=_read(cam, DRAWN, radius),
        fine=_read(cam, MEASURED, radius),
        infinite=_kinks(cam),
        limits=limits,
        ends=(("min", False), ("max", True)),
        bad=(-np.inf, 0.0),
    )


def _less(value: float | None) -> float | None:
    return None if value is None else -value


def _read(cam: Cam, options: MotionOptions, value: Callable[[CamProfile], Array]) -> Trace:
    rows = table_rows(cam, options)
    return Trace(rows.degrees, rows.side, value(cam.at(rows.theta, rows.left)))


def _corners(cam: Cam) -> Trace:
    """Where the traced curve has a corner: infinitely convex or hollow, as the material sees it."""
    theta = cam.joints.breaking(1)
    left, right = cam.at(theta, np.ones(len(theta), dtype=bool)), cam.at(theta)
    turn = left.normal_x * right.normal_y - left.normal_y * right.normal_x
    mirror = 1.0 if cam.rotation == "ccw" else -1.0  # a ccw cam's curve runs clockwise
    return _infinite(theta, -mirror * cam.flank.side * turn)


def _kinks(cam: Cam) -> Trace:
    """Where the velocity jumps: the face rocks on a corner, or would have to leave the cam."""
    theta = cam.joints.breaking(1)
    left, right = (cam.motion.derivatives(theta, 3, side) for side in ("left", "right"))
    return _infinite(theta, right[1] - left[1])


def _infinite(theta: Array, sign: Array) -> Trace:
    return Trace(in_degrees(theta), np.zeros(len(theta), dtype=np.int64), np.inf * np.sign(sign))


CONTACT = Exporter(
    "contact.svg", "Pressure angle and profile radius", "image/svg+xml", ".svg", _contact,
    PictureOptions, "Diagrams over the cam angle, of every roller's path and every flank; with a "
    "load contact force, Hertz pressure and torque, too.",
)  # fmt: skip
