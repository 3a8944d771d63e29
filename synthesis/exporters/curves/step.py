"""STEP AP242 (ISO 10303-242): entities as clear text (ISO 10303-21), products, and exact curves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from synthesis.design.design import Design
from synthesis.exporters.curves.exact import FINEST, ExactCurve, ExactOptions
from synthesis.exporters.exporter import Exporter, FileContent

SCHEMA = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }"
NO_TIME = "1980-01-01T00:00:00"  # the same design, the same bytes: no clock


class Provenance(Protocol):
    """What a file says of its origin: id and name of the design, version of the engine."""

    @property
    def id(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def engine_version(self) -> str: ...


class Entities:
    """Entities of a data section."""

    def __init__(self) -> None:
        self._lines: list[str] = []

    def add(self, kind: str, *attributes: str) -> str:
        """A simple entity; its reference, as ``#7``."""
        return self._append(f"{kind}({','.join(attributes)})")

    def add_complex(self, *parts: tuple[str, Sequence[str]]) -> str:
        """An entity of several types at once, by their names in alphabetical order."""
        types = [f"{kind}({','.join(given)})" for kind, given in parts]
        return self._append(f"({' '.join(types)})")

    def _append(self, text: str) -> str:
        self._lines.append(text)
        return f"#{len(self._lines)}"

    def lines(self) -> Iterable[str]:
        """The data section."""
        return (f"#{i}={text};" for i, text in enumerate(self._lines, start=1))


def exchange_file(design: Provenance, title: str, data: Iterable[str]) -> bytes:
    """A whole file, which says what made it and from which design."""
    version = f"Camwright {design.engine_version}"
    lines = [
        "ISO-10303-21;",
        "HEADER;",
        f"FILE_DESCRIPTION(({text(title)},{text(f'design {design.id}')}),'2;1');",
        f"FILE_NAME({text(design.name or design.id)},'{NO_TIME}',(''),(''),{text(version)},"
        f"{text(version)},'');",
        f"FILE_SCHEMA(({text(SCHEMA)}));",
        "ENDSEC;",
        "DATA;",
        *data,
        "ENDSEC;",
        "END-ISO-10303-21;",
        "",
    ]
    return "\n".join(lines).encode("ascii")


def text(value: str) -> str:
    """A string: quotes and backslashes doubled, what is not ASCII by its code."""
    out = []
    for letter in value:
        if letter in "'\\":
            out.append(2 * letter)
        elif " " <= letter <= "~":
            out.append(letter)
        elif ord(letter) < 0x10000:
            out.append(f"\\X2\\{ord(letter):04X}\\X0\\")
        else:
            out.append(f"\\X4\\{ord(letter):08X}\\X0\\")
    return f"'{''.join(out)}'"


def real(value: float) -> str:
    """The shortest decimal number that reads back to the same double, with the point it needs."""
    mantissa, _, exponent = repr(float(value)).partition("e")
    point = "" if "." in mantissa else "."
    return f"{mantissa}{point}E{exponent}" if exponent else f"{mantissa}{point}"


def many(values: Iterable[str]) -> str:
    """A list."""
    return f"({','.join(values)})"


def shape_file(
    design: Provenance,
    title: str,
    kind: str,
    write: Callable[[Entities], str],
    error: float = FINEST,
    meaning: str = "largest distance from the true curve",
    name: str = "",
) -> bytes:
    """A file with one shape.

    Args:
        title: for people. kind: entity of the shape's representation.
        write: writes the shape; returns the reference.
        error: uncertainty of the shape [mm], and its meaning. name: of the shape; "": the cam's.
    """
    data = Entities()
    shared = context(data, max(error, FINEST), meaning)
    label = text(name or design.name or f"cam {design.id}")
    origin = data.add("CARTESIAN_POINT", "''", many(map(real, (0.0, 0.0, 0.0))))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", origin, *axes(data))
    shape = data.add(kind, label, many([placed, write(data)]), shared)
    data.add("SHAPE_DEFINITION_REPRESENTATION", product(data, design), shape)
    return exchange_file(design, title, data.lines())


def axes(data: Entities) -> tuple[str, str]:
    """The z axis and the x axis."""
    return (
        data.add("DIRECTION", "''", many(map(real, (0.0, 0.0, 1.0)))),
        data.add("DIRECTION", "''", many(map(real, (1.0, 0.0, 0.0)))),
    )


def context(data: Entities, uncertainty: float, meaning: str) -> str:
    """Three dimensions, mm, radians, and how near is the same place."""
    length = data.add_complex(
        ("LENGTH_UNIT", ()), ("NAMED_UNIT", ("*",)), ("SI_UNIT", (".MILLI.", ".METRE."))
    )
    angle = data.add_complex(
        ("NAMED_UNIT", ("*",)), ("PLANE_ANGLE_UNIT", ()), ("SI_UNIT", ("$", ".RADIAN."))
    )
    solid = data.add_complex(
        ("NAMED_UNIT", ("*",)), ("SI_UNIT", ("$", ".STERADIAN.")), ("SOLID_ANGLE_UNIT", ())
    )
    near = data.add(
        "UNCERTAINTY_MEASURE_WITH_UNIT", f"LENGTH_MEASURE({real(uncertainty)})", length,
        "'distance_accuracy_value'", text(meaning),
    )  # fmt: skip
    return data.add_complex(
        ("GEOMETRIC_REPRESENTATION_CONTEXT", ("3",)),
        ("GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT", (many([near]),)),
        ("GLOBAL_UNIT_ASSIGNED_CONTEXT", (many([length, angle, solid]),)),
        ("REPRESENTATION_CONTEXT", ("''", "'3D'")),
    )


def product(data: Entities, design: Provenance) -> str:
    """The cam as a product, which the geometry is the shape of."""
    application = data.add("APPLICATION_CONTEXT", "'managed model based 3d engineering'")
    data.add(
        "APPLICATION_PROTOCOL_DEFINITION", "'international standard'",
        "'ap242_managed_model_based_3d_engineering'", "2014", application,
    )  # fmt: skip
    inside = data.add("PRODUCT_CONTEXT", "''", application, "'mechanical'")
    name = text(design.name or "cam")
    made = f"Camwright {design.engine_version}, design {design.id}"
    made_of = data.add("PRODUCT", text(design.id), name, text(made), many([inside]))
    data.add("PRODUCT_RELATED_PRODUCT_CATEGORY", "'part'", "$", many([made_of]))
    formation = data.add("PRODUCT_DEFINITION_FORMATION", "''", "''", made_of)
    whole = data.add("PRODUCT_DEFINITION_CONTEXT", "'part definition'", application, "'design'")
    definition = data.add("PRODUCT_DEFINITION", "'design'", "''", formation, whole)
    return data.add("PRODUCT_DEFINITION_SHAPE", "''", "''", definition)


def _profile(design: Design, options: ExactOptions) -> FileContent:
    curve = ExactCurve.of(design, options)

    def write(data: Entities) -> str:
        return data.add("GEOMETRIC_CURVE_SET", text(curve.name), many([_spline(data, curve)]))

    title = f"Cam curve {curve.name}, within {curve.spline.error:.2g} mm of the true curve"
    kind = "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION"
    return curve.file(shape_file(design, title, kind, write, curve.spline.error, name=curve.name))


def _spline(data: Entities, curve: ExactCurve) -> str:
    points = [
        data.add("CARTESIAN_POINT", "''", many(map(real, point))) for point in curve.points.tolist()
    ]
    knots, times = curve.knots
    return data.add(
        "B_SPLINE_CURVE_WITH_KNOTS", text(curve.name), str(curve.spline.degree), many(points),
        ".UNSPECIFIED.", ".T.", ".F.", many(map(str, times.tolist())),
        many(map(real, knots.tolist())), ".UNSPECIFIED.",
    )  # fmt: skip


PROFILE = Exporter(
    "step", "STEP AP242, exact curve", "model/step", ".step", _profile, ExactOptions,
    "Master geometry for CAD: one closed B-spline curve within tolerance_um of the true curve, in "
    "mm, as wireframe.",
    by_default=False,
)  # fmt: skip
