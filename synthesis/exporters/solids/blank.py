"""A cam as a stack of slabs: what a solid is made of, and how much of it there is.

plate     the flank is touched from outside: all within it
ring      it is touched from inside: all between it and a circle
disc      a groove between two flanks in one side of a round disc
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from synthesis.catalogue.hub import KEYED_BORES, standard_keyway
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.curves.exact import ExactCurve, ExactOptions
from synthesis.exporters.options import Axial, BoreDiameter, CurveName, Options, PlacedCurve, Turn
from synthesis.exporters.samples.cam import Cam
from synthesis.spec.design_spec import DesignSpec

NO_RIM = 0.1  # of the largest radius: wall of a ring or a disc where the design says none
SEARCHED = 7201  # places of a flank at which its least and largest radius are taken

Length = Annotated[float | None, Field(gt=0.0, le=1e6)]


@dataclass(frozen=True, kw_only=True)
class SolidOptions(Options):
    """The cam as a body; ``z_mm``: of its back."""

    curve: Literal["profile", "main", "counter"] = "profile"
    """Of conjugate cams, which; otherwise `profile`."""
    thickness_mm: Annotated[float, Field(gt=0.0, le=1e5)] = 10.0
    """Of plate, ring or disc."""
    tolerance_um: Annotated[float, Field(ge=1e-3, le=1e3)] = 1e-3
    """Largest distance of the flanks from the true curve, along its normal [µm]. What is reached is
    reported in the header Camwright-Curve-Error-Mm."""
    bore_mm: BoreDiameter = None
    keyway: bool = False
    """A keyway in the bore, by DIN 6885-1; with the design's own bore, as its spec says."""
    keyway_width_mm: Length = None
    """Width of the keyway; left out: by the bore."""
    keyway_depth_mm: Length = None
    """Depth beyond the bore's radius; left out: by the bore."""
    keyway_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 90.0
    """Direction of the keyway in the cam's own frame; in a cam set every cam has its own."""
    hub_diameter_mm: Length = None
    """Of a hub on the back; left out: the design's, where a length is given."""
    hub_length_mm: Length = None
    """How far the hub stands out."""
    groove_depth_mm: Length = None
    """Of a groove; left out: half the thickness."""
    outer_diameter_mm: Length = None
    """Of a ring or a grooved disc; left out: the largest radius and the rim, or a tenth of that
    radius where the design has no rim."""
    turn_deg: Turn = 0.0
    z_mm: Axial = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.groove_depth_mm is not None and not self.groove_depth_mm < self.thickness_mm:
            raise self.refusal(
                "groove_depth_mm",
                f"The groove must be less deep than the disc is thick, {self.thickness_mm:g} mm.",
                "Make the disc thicker, or the groove less deep.",
            )

    def with_shaft(self, spec: DesignSpec) -> SolidOptions:
        """The same with the bore, the keyway and the hub of a spec's shaft where none are given.

        InputError where a hub or a keyway is not wholly given then.
        """
        bore = spec.shaft_diameter_mm if self.bore_mm is None else self.bore_mm
        keyway = self.keyway or (spec.keyway and self.bore_mm is None)
        hub = spec.hub if self.hub_diameter_mm is None else self.hub_diameter_mm
        if (self.hub_length_mm is not None) != (self.hub_diameter_mm is not None):
            missing = "hub_length_mm" if self.hub_length_mm is None else "hub_diameter_mm"
            if missing == "hub_length_mm" or hub is None:
                rule = "A hub has a diameter and a length."
                raise self.refusal(missing, rule, "Give both of them, or neither.")
        if keyway and bore is None:
            raise self.refusal("bore_mm", "A keyway needs a bore.", "Give its diameter.")
        hub = None if self.hub_length_mm is None else hub
        return replace(self, bore_mm=bore, keyway=keyway, hub_diameter_mm=hub)


class Stroke(NamedTuple):
    """A part of an outline, by what draws it, and that method's arguments: see ``body.Edges``."""

    method: str
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Outline:
    """A closed line around the axis.

    Attributes:
        area: within it [mm²]. radii: smallest and largest distance from the axis [mm].
        strokes: that follow one another. error: largest distance from what it stands for [mm].
    """

    area: float
    radii: tuple[float, float]
    strokes: tuple[Stroke, ...]
    error: float = 0.0


def circle(radius: float) -> Outline:
    """A circle about the axis [mm]."""
    return Outline(math.pi * radius**2, (radius, radius), (Stroke("circle", (radius,)),))


def bore(radius: float, width: float, depth: float, direction: float) -> Outline:
    """A bore around the axis with a keyway.

    Args:
        radius: [mm]. width: of the keyway. depth: beyond the bore's radius.
        direction: in which it lies from the axis [rad].
    """
    half, top = 0.5 * width, radius + depth
    shoulder = math.sqrt(radius**2 - 0.25 * width**2)  # where the sides begin, along the keyway
    cos, sin = math.cos(direction), math.sin(direction)
    places = ((shoulder, half), (shoulder, -half), (top, -half), (top, half))
    a, b, c, d = ((cos * u - sin * v, sin * u + cos * v) for u, v in places)
    # the circle, and the keyway less what of it is the circle's
    within = half * shoulder + radius * radius * math.asin(half / radius)
    area = math.pi * radius * radius + (width * top - within)
    lines = [Stroke("line", ends) for ends in ((b, c), (c, d), (d, a))]
    strokes = (Stroke("arc", (radius, a, b)), *lines)
    return Outline(area, (radius, math.hypot(half, top)), strokes)


@dataclass(frozen=True)
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


@dataclass(frozen=True)
class Blank:
    """All slabs of a cam; they touch, and together are one body. ``error``: of its flanks [mm]."""

    slabs: tuple[Slab, ...]
    error: float

    @property
    def volume(self) -> float:
        """[mm³]."""
        return sum(slab.volume for slab in self.slabs)


def blank(design: Design, options: SolidOptions) -> Blank:
    """The slabs of a design's cam; InputError where bore, hub or wall do not fit it."""
    options = options.with_shaft(design.spec)
    cam = Cam.of(design, PlacedCurve(curve=options.curve))
    flanks = [flank for flank in cam.follower.flanks if flank.path == cam.flank.path]
    edges = {
        flank.side: _edge(design, options, flank.name or "profile")  # type: ignore[arg-type]
        for flank in reversed(flanks)
    }
    within, around = edges.get(1), edges.get(-1)
    error = max(edge.error for edge in edges.values())
    holes = bores(options)
    low = options.z_mm or 0.0
    high = low + options.thickness_mm
    hub = []
    if options.hub_diameter_mm is not None and options.hub_length_mm is not None:
        below = low - options.hub_length_mm
        hub.append(Slab(circle(0.5 * options.hub_diameter_mm), holes, below, low))
    if within is not None:
        _check_room(options, holes, within.radii[0])
    if around is None:
        assert within is not None
        _refuse(options, ("outer_diameter_mm", "groove_depth_mm"), "a plate, with nothing round it")
        return Blank((Slab(within, holes, low, high), *hub), error)
    wall = circle(_outer_radius(options, around.radii[1], max(flank.rim for flank in flanks)))
    if within is None:
        shaft = ("bore_mm", "hub_diameter_mm", "groove_depth_mm")
        _refuse(options, shaft, "a ring, with no material around its axis and no groove")
        return Blank((Slab(wall, [around], low, high),), error)
    floor = high - (options.groove_depth_mm or 0.5 * options.thickness_mm)
    sides = Slab(within, holes, floor, high), Slab(wall, [around], floor, high)
    return Blank((Slab(wall, holes, low, floor), *sides, *hub), error)


def _edge(design: Design, options: SolidOptions, name: CurveName) -> Outline:
    """A flank as the edge of a slab."""
    exact = ExactOptions(curve=name, tolerance_um=options.tolerance_um, turn_deg=options.turn_deg)
    curve = ExactCurve.of(design, exact)
    spline = curve.spline
    radius = np.hypot(*spline.at(np.linspace(spline.knots[0], spline.knots[-1], SEARCHED)).T)
    ends = float(radius.min()), float(radius.max())
    return Outline(spline.area, ends, (Stroke("spline", (curve,)),), spline.error)


def bores(options: SolidOptions) -> list[Outline]:
    """The bore if there is one, its keyway by DIN 6885-1 (as ISO 773) where no size is given."""
    diameter, width, depth = options.bore_mm, options.keyway_width_mm, options.keyway_depth_mm
    if diameter is None:
        return []
    if not options.keyway:
        return [circle(0.5 * diameter)]
    if width is None or depth is None:
        sizes = standard_keyway(diameter)
        if sizes is None:
            remedy = "Give keyway_width_mm and keyway_depth_mm."
            raise options.refusal("bore_mm", KEYED_BORES, remedy)
        width, depth = width or sizes[0], depth or sizes[1]
    if width >= diameter:
        rule = f"The keyway must be narrower than the bore, {diameter:g} mm."
        remedy = "Make it narrower, or the bore wider."
        raise InputError("/keyway_width_mm", width, rule, remedy)
    direction = math.radians(options.keyway_deg + options.turn_deg)
    return [bore(0.5 * diameter, width, depth, direction)]


def _check_room(options: SolidOptions, holes: list[Outline], room: float) -> None:
    """Bore and keyway within the hub, both within the cam's smallest radius."""
    hub = options.hub_diameter_mm
    if hub is not None and 0.5 * hub >= room:
        rule = f"The hub must stay within the cam's smallest radius, {room:.6g} mm."
        remedy = f"Make it smaller than {2.0 * room:.6g} mm."
        raise options.refusal("hub_diameter_mm", rule, remedy)
    room = room if hub is None else 0.5 * hub
    if holes and holes[0].radii[1] >= room:
        raise options.refusal(
            "bore_mm",
            f"The bore{' with its keyway' * options.keyway} reaches {holes[0].radii[1]:.6g} mm "
            f"from the axis, where the cam or its hub has {room:.6g} mm at its narrowest.",
            "Take a smaller bore or hub, or ask for a larger base radius.",
        )


def _refuse(options: SolidOptions, names: Sequence[str], kind: str) -> None:
    """What this kind of cam has not."""
    for name in names:
        if getattr(options, name) is not None:
            raise options.refusal(name, f"The cam is {kind}.", "Leave it out.")


def _outer_radius(options: SolidOptions, largest: float, rim: float) -> float:
    """Of a ring or disc whose outer flank reaches so far [mm]."""
    if options.outer_diameter_mm is None:
        return largest + (rim or NO_RIM * largest)
    if 0.5 * options.outer_diameter_mm <= largest:
        rule = f"The outer flank reaches {largest:.6g} mm from the axis."
        remedy = f"Make it larger than {2.0 * largest:.6g} mm."
        raise options.refusal("outer_diameter_mm", rule, remedy)
    return 0.5 * options.outer_diameter_mm
