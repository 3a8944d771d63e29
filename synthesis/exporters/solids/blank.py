"""A cam as a stack of slabs: what a solid is made of, and how much of it there is.

plate     the flank is touched from outside: all within it
ring      it is touched from inside: all between it and a circle
disc      a groove between two flanks in one side of a round disc
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.followers.flank import Flank
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.curves.exact import ExactCurve, exact_curve
from synthesis.exporters.curves.exact_options import ExactOptions
from synthesis.exporters.options import CurveName
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.solids.keyway import Bore, bore_of
from synthesis.exporters.solids.outline import Circle, Outline, Pen
from synthesis.exporters.solids.solid_options import SolidOptions

NO_RIM = 0.1  # of the largest radius: wall of a ring or a disc where the design says none


@dataclass(frozen=True, eq=False)
class Edge(Outline):
    """A flank as the edge of a slab."""

    curve: ExactCurve

    @property
    def area(self) -> float:
        return self.curve.spline.area

    def draw(self, pen: Pen) -> None:
        pen.spline(self.curve)

    @property
    def radii(self) -> tuple[float, float]:
        """Smallest and largest distance from the axis [mm]."""
        spline = self.curve.spline
        where = np.linspace(spline.knots[0], spline.knots[-1], 7201)
        radius = np.hypot(*spline.at(where).T)
        return float(radius.min()), float(radius.max())


@dataclass(frozen=True, eq=False)
class Slab:
    """What lies within an outline and outside others, between two heights [mm]."""

    outside: Outline
    holes: Sequence[Outline]
    low: float
    high: float

    @property
    def volume(self) -> float:
        """[mm³]."""
        area = self.outside.area - sum(hole.area for hole in self.holes)
        return area * (self.high - self.low)


@dataclass(frozen=True, eq=False)
class Blank:
    """All slabs of a cam; they touch, and together are one body.

    ``error``: of its flanks [mm].
    """

    slabs: tuple[Slab, ...]
    error: float

    @property
    def volume(self) -> float:
        """[mm³]."""
        return sum(slab.volume for slab in self.slabs)


def blank(design: Design, options: SolidOptions) -> Blank:
    """The slabs of a design's cam.

    Raises:
        InputError: there is no cam, or bore, hub or wall do not fit it.
    """
    cam = Cam.of(design, _exact(options, options.curve))
    within, around = (_edge(design, options, cam, side) for side in (1, -1))
    bore = _bore(options)
    low = options.z_mm or 0.0
    high = low + options.thickness_mm
    edges = [edge for edge in (within, around) if edge is not None]
    error = max(edge.curve.spline.error for edge in edges)
    if within is not None:
        _check_room(options, bore, within.radii[0])
    if around is None:
        assert within is not None
        _refuse(options, ("outer_diameter_mm", "groove_depth_mm"), "a plate, with nothing round it")
        return Blank((Slab(within, bore, low, high), *_hub(options, bore, low)), error)
    wall = Circle(_outer_radius(options, cam, around))
    if within is None:
        shaft = ("bore_mm", "hub_diameter_mm", "groove_depth_mm")
        _refuse(options, shaft, "a ring, with no material around its axis and no groove")
        return Blank((Slab(wall, [around], low, high),), error)
    depth = options.groove_depth_mm or 0.5 * options.thickness_mm
    floor = high - depth
    slabs = (
        Slab(wall, bore, low, floor),
        Slab(within, bore, floor, high),
        Slab(wall, [around], floor, high),
        *_hub(options, bore, low),
    )
    return Blank(slabs, error)


def _exact(options: SolidOptions, curve: CurveName) -> ExactOptions:
    return ExactOptions(
        curve=curve, tolerance_um=options.tolerance_um, turn_deg=options.turn_deg, z_mm=0.0
    )


def _edge(design: Design, options: SolidOptions, cam: Cam, side: int) -> Edge | None:
    """The flank of this cam that lies on a side of its pitch curve."""
    for flank in _flanks(cam):
        if flank.side == side:
            name: CurveName = flank.name or "profile"  # type: ignore[assignment]
            return Edge(exact_curve(design, _exact(options, name)))
    return None


def _flanks(cam: Cam) -> list[Flank]:
    return [each for each in cam.follower.flanks if each.path == cam.flank.path]


def _bore(options: SolidOptions) -> list[Bore]:
    if options.bore_mm is None:
        return []
    direction = options.keyway_deg + options.turn_deg
    return [
        bore_of(
            options.bore_mm, options.keyway, options.keyway_width_mm, options.keyway_depth_mm,
            direction,
        )
    ]  # fmt: skip


def _hub(options: SolidOptions, bore: list[Bore], low: float) -> list[Slab]:
    if options.hub_diameter_mm is None or options.hub_length_mm is None:
        return []
    return [Slab(Circle(0.5 * options.hub_diameter_mm), bore, low - options.hub_length_mm, low)]


def _check_room(options: SolidOptions, bore: list[Bore], room: float) -> None:
    """Bore and keyway within the hub, both within the cam's smallest radius."""
    hub = options.hub_diameter_mm
    if hub is not None and 0.5 * hub >= room:
        raise InputError(
            "/hub_diameter_mm", hub,
            f"The hub must stay within the cam's smallest radius, {room:.6g} mm.",
            f"Make it smaller than {2.0 * room:.6g} mm.",
        )  # fmt: skip
    room = room if hub is None else 0.5 * hub
    if bore and bore[0].reach >= room:
        raise InputError(
            "/bore_mm", options.bore_mm,
            f"The bore{' with its keyway' * bool(bore[0].width)} reaches {bore[0].reach:.6g} mm "
            f"from the axis, where the cam or its hub has {room:.6g} mm at its narrowest.",
            "Take a smaller bore or hub, or ask for a larger base radius.",
        )  # fmt: skip


def _refuse(options: SolidOptions, names: Sequence[str], kind: str) -> None:
    """What this kind of cam has not."""
    for name in names:
        value = getattr(options, name)
        if value is not None:
            raise InputError(f"/{name}", value, f"The cam is {kind}.", "Leave it out.")


def _outer_radius(options: SolidOptions, cam: Cam, around: Edge) -> float:
    largest = around.radii[1]
    if options.outer_diameter_mm is None:
        rim = max(flank.rim for flank in _flanks(cam))
        return largest + (rim or NO_RIM * largest)
    if 0.5 * options.outer_diameter_mm <= largest:
        raise InputError(
            "/outer_diameter_mm", options.outer_diameter_mm,
            f"The outer flank reaches {largest:.6g} mm from the axis.",
            f"Make it larger than {2.0 * largest:.6g} mm.",
        )  # fmt: skip
    return 0.5 * options.outer_diameter_mm
