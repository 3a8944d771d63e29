"""STEP AP242 (ISO 10303-242): one closed B-spline curve as wireframe geometry, in mm."""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.curves.exact import ExactCurve, exact_curve, facts
from synthesis.exporters.curves.exact_options import ExactOptions
from synthesis.exporters.curves.part21 import Entities, Told, exchange_file, many, real, text
from synthesis.exporters.exporter import Exporter, FileContent

SCHEMA = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }"
FINEST = 1e-7  # uncertainty that a reader may work with [mm]; below, kernels cannot


def _profile(design: Design, options: ExactOptions) -> FileContent:
    curve = exact_curve(design, options)
    data = Entities()
    shared = context(data, max(curve.spline.error, FINEST))
    name = text(curve.name)
    origin = data.add("CARTESIAN_POINT", "''", many(map(real, (0.0, 0.0, 0.0))))
    placed = data.add("AXIS2_PLACEMENT_3D", "''", origin, *axes(data))
    drawn = data.add("GEOMETRIC_CURVE_SET", name, many([_spline(data, curve)]))
    shape = data.add(
        "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION", name, many([placed, drawn]), shared
    )
    data.add("SHAPE_DEFINITION_REPRESENTATION", product(data, design), shape)
    title = f"Cam curve {curve.name}, within {curve.spline.error:.2g} mm of the true curve"
    return FileContent(exchange_file(design, title, SCHEMA, data.lines()), facts(curve))


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


def axes(data: Entities) -> tuple[str, str]:
    """The z axis and the x axis."""
    return (
        data.add("DIRECTION", "''", many(map(real, (0.0, 0.0, 1.0)))),
        data.add("DIRECTION", "''", many(map(real, (1.0, 0.0, 0.0)))),
    )


def context(
    data: Entities, uncertainty: float, meaning: str = "largest distance from the true curve"
) -> str:
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


def product(data: Entities, design: Told) -> str:
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


PROFILE = Exporter(
    "step",
    "STEP AP242, exact curve",
    "model/step",
    ".step",
    _profile,
    ExactOptions,
    by_default=False,
    purpose="Master geometry for CAD: one closed B-spline curve within tolerance_um of the true "
    "curve, in mm, as wireframe.",
)
