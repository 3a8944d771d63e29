"""What a caller may choose about a file, and what makes sense.

Each field stands once, with its rule and, below it or in its type, its meaning: query parameters,
the command line and the catalogue are made from it.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Literal, get_args, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from synthesis.errors import InputError

CurveName = Literal[
    "profile", "pitch", "cutter", "inner", "outer", "outer_cutter",
    "main", "counter", "counter_pitch", "counter_cutter",
]  # fmt: skip

Theme = Literal["auto", "light", "dark", "print"]

MAX_POINTS_PER_DEGREE = 100.0  # of a point file
MAX_POINTS = 36_000  # of a point file: MAX_POINTS_PER_DEGREE all round
MAX_TURNS = 100  # of a motion: MAX_POINTS rows, one for each degree
MIN_TOLERANCE_UM = 1e-4  # µm: finer than any machine, coarser than rounding
CURVES: tuple[CurveName, ...] = get_args(CurveName)
# Keywords of JSON Schema in words.
BOUNDS = {
    "exclusiveMinimum": "above", "minimum": "at least",
    "exclusiveMaximum": "below", "maximum": "at most",
}  # fmt: skip

Density = Annotated[
    float, Field(gt=0.0, le=MAX_POINTS_PER_DEGREE, description="Points per degree of cam angle.")
]
Count = Annotated[
    int | None,
    Field(
        ge=36,
        le=MAX_POINTS,
        description="Points in a turn, evenly over the cam angle; decides instead of "
        "points_per_degree.",
    ),
]
ChordTolerance = Annotated[
    float | None,
    Field(
        ge=MIN_TOLERANCE_UM,
        le=1e6,
        description="Largest distance of a chord from the curve [µm]; decides instead of points "
        "and points_per_degree.",
    ),
]
StartAngle = Annotated[
    float | None,
    Field(
        ge=-360.0,
        le=360.0,
        description="Cam angle of the first point; left out: the middle of the longest dwell, "
        "where the ends of a spline do least harm.",
    ),
]
Turn = Annotated[
    float,
    Field(
        ge=-360.0,
        le=360.0,
        description="Turn the points about the cam's axis by this angle, counter-clockwise "
        "positive: the cam as it sits on a shaft. The drawing (svg) stays as it is.",
    ),
]
Axial = Annotated[
    float | None,
    Field(
        ge=-1e6,
        le=1e6,
        description="Position along the axis: the third column of point files (0 where it is "
        "left out), and a column z_mm of tables.",
    ),
]
BoreDiameter = Annotated[
    float | None, Field(
        gt=0.0, le=1e6,
        description="Diameter of the bore around the cam's axis; left out: of a plane cam the "
        "design's shaft_diameter_mm, else none.",
    )
]  # fmt: skip
Decimals = Annotated[int, Field(ge=0, le=15, description="Decimals of a coordinate in mm.")]


@cache
def _field_texts(module: str) -> dict[str, dict[str, str]]:
    """The strings below the fields of the classes of a module, by class, each on one line.

    A module is parsed once: `inspect.getsource` of a class parses all of its module.
    """
    texts: dict[str, dict[str, str]] = {}
    statements = ast.parse(inspect.getsource(sys.modules[module])).body
    for each in (each for each in statements if isinstance(each, ast.ClassDef)):
        own = texts[each.name] = {}
        for statement, below in pairwise(each.body):
            match statement, below:
                case ast.AnnAssign(ast.Name(name)), ast.Expr(ast.Constant(str(text))):
                    own[name] = " ".join(text.split())
    return texts


def _form(options: type[Any]) -> type[BaseModel]:
    hints, texts = get_type_hints(options, include_extras=True), dict[str, str]()
    for family in reversed(options.__mro__[:-1]):
        texts |= _field_texts(family.__module__).get(family.__name__, {})
    members: dict[str, Any] = {}
    for each in fields(options):
        described = hints[each.name]
        if each.name in texts:
            described = Annotated[described, Field(description=texts[each.name])]
        members[each.name] = described, each.default
    settings = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)
    return create_model(options.__name__, __config__=settings, __doc__=options.__doc__, **members)


# A class of options as a model: for query parameters and for JSON Schema.
form: Callable[[Any], type[BaseModel]] = cache(_form)


@dataclass(frozen=True)
class Options:
    """What may be chosen about a file; the fields are checked where it is made."""

    def __post_init__(self) -> None:
        model = form(type(self))
        try:
            model.model_validate({each.name: getattr(self, each.name) for each in fields(self)})
        except ValidationError as wrong:
            error = wrong.errors()[0]
            name = str(error["loc"][0])
            schema = model.model_json_schema()["properties"][name]
            raise InputError(f"/{name}", error["input"], _rule(schema), _way_out(schema)) from None

    def refusal(self, name: str, rule: str, remedy: str) -> InputError:
        """The error that says why the value of a field cannot be."""
        return InputError(f"/{name}", getattr(self, name), rule, remedy)


def _rule(schema: dict[str, Any]) -> str:
    """What a field has to satisfy, in words."""
    # of a number that may be left out the facts stand first, those of null last
    facts = {k: v for each in (*schema.get("anyOf", ())[::-1], schema) for k, v in each.items()}
    if "enum" in facts:
        return f"This must be one of {', '.join(map(str, facts['enum']))}."
    words = [f"{word} {facts[key]:g}" for key, word in BOUNDS.items() if key in facts]
    kind = "a whole number" if facts.get("type") == "integer" else "a finite number"
    return f"This must be {kind}{', ' if words else ''}{' and '.join(words)}."


def _way_out(schema: dict[str, Any]) -> str:
    default = schema["default"]
    return "Leave it out, or correct it." if default is None else f"Leave it out for {default!r}."


@dataclass(frozen=True)
class Sampled(Options):
    """Options with ``points_per_degree``, ``points`` and perhaps ``tolerance_um``."""

    @property
    def count(self) -> float:
        """Points in a turn, evenly over the cam angle."""
        given = vars(self)
        return float(given["points"] or 360.0 * given["points_per_degree"])

    @property
    def chord_mm(self) -> float | None:
        """Largest distance of a chord from the curve, which then decides [mm]."""
        tolerance_um = vars(self).get("tolerance_um")
        return None if tolerance_um is None else 1e-3 * tolerance_um


@dataclass(frozen=True, kw_only=True)
class PlacedCurve(Options):
    """Which curve of a cam, and where it stands."""

    curve: CurveName = "profile"
    """The cam's profile, the path of the roller's centre, or the path of a cutter's or grinding
    wheel's centre (with cutter_diameter_mm). A groove has an inner and an outer profile, conjugate
    cams a main and a counter profile and a counter pitch curve; `profile` is the first of them. The
    drawing (svg) shows all."""
    turn_deg: Turn = 0.0
    z_mm: Axial = None
    cutter_diameter_mm: Annotated[float | None, Field(gt=0.0, le=1e6)] = None
    """Of the cutter or grinding wheel whose centre the curves cutter, outer_cutter and
    counter_cutter are the path of."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if is_cutter(self.curve) != (self.cutter_diameter_mm is not None):
            raise self.refusal(
                "cutter_diameter_mm",
                f"The path of a cutter's centre, and no other curve ({self.curve}), has a cutter "
                "diameter.",
                "Give both curve=cutter and cutter_diameter_mm, or leave the diameter out.",
            )


@dataclass(frozen=True)
class CurveOptions(Sampled, PlacedCurve):
    """How a curve of a cam is sampled; not below one point in 10°."""

    points_per_degree: Density = 4.0
    tolerance_um: ChordTolerance = None
    points: Count = None


@dataclass(frozen=True)
class ProfileOptions(CurveOptions):
    """How the cam's curve is sampled; drawings show all curves of a cam."""


@dataclass(frozen=True)
class PointOptions(CurveOptions):
    """How the points of a curve are written for the readers of point files."""

    start_deg: StartAngle = None
    closed: bool | None = None
    """Repeat the first point at the end. Left out: as readers of the format expect it."""
    overlap_points: Annotated[int, Field(ge=0, le=MAX_POINTS)] = 0
    """Run on past the end by so many points, which repeat the first ones: a spline that is not
    closed then has its ends where they are cut off."""
    direction: Literal["cam_angle", "ccw", "cw"] = "cam_angle"
    """Sense in which the points run round the cam: with rising cam angle (against the cam's
    rotation), counter-clockwise, or clockwise."""
    decimals: Decimals = 10


@dataclass(frozen=True)
class RowOptions(Sampled):
    """How the motion is sampled: rows evenly over the cam angle, not below one in 10°."""

    points_per_degree: Density = 1.0
    points: Count = None


@dataclass(frozen=True)
class MotionOptions(RowOptions):
    """The same over one or several turns."""

    turns: Annotated[int, Field(ge=1, le=MAX_TURNS)] = 1
    """Turns of the cam, through which angle and time run on."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.count * self.turns > MAX_POINTS:
            most = int(MAX_POINTS / self.count)
            rule = f"A file has at most {MAX_POINTS} rows, which here are {most} turns."
            raise self.refusal("turns", rule, "Ask for fewer turns, or fewer points.")


Colours = Annotated[
    Theme,
    Field(
        description="`auto` is light, and dark on a screen that asks for it; `print` is black on "
        "white."
    ),
]


@dataclass(frozen=True)
class PictureOptions(Options):
    """How a picture or a page looks."""

    theme: Colours = "auto"


PixelColours = Annotated[
    Literal["light", "dark", "print"],
    Field(description="`print` is black on white; there is no `auto`: pixels know no screen."),
]
PixelWidth = Annotated[int, Field(ge=200, le=6000, description="Width of the picture.")]


@dataclass(frozen=True)
class PixelOptions(Options):
    """How a picture of pixels looks; its height follows from its width."""

    theme: PixelColours = "light"
    width_px: PixelWidth = 1600


@dataclass(frozen=True)
class CamDrawingOptions(ProfileOptions):
    """How finely the drawing of a cam is drawn, and how it looks."""

    theme: Colours = "auto"


@dataclass(frozen=True)
class DiagramOptions(MotionOptions):
    """How finely diagrams of the motion are drawn, and how they look."""

    theme: Colours = "auto"


def is_pitch(curve: CurveName) -> bool:
    """Whether a curve is the path of a roller's centre."""
    return curve.endswith("pitch")


def is_cutter(curve: CurveName) -> bool:
    """Whether a curve is the path of a cutter's centre."""
    return curve.endswith("cutter")
