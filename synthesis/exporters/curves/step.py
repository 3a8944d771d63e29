"""STEP AP242 (ISO 10303-242): entities as clear text (ISO 10303-21), products, and exact curves."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np
from scipy.interpolate import NdBSpline

from synthesis.design.design import Design
from synthesis.exporters.curves.exact import FINEST, ExactCurve, ExactOptions
from synthesis.exporters.exporter import FileContent, asset, design_format
from synthesis.numerics.piecewise import Array

SCHEMA = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }"
CONTEXT, PLACED = "#5", "#9"  # entities of ``context.step``: units and accuracy, the origin
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
        self._lines.append(f"{kind}({','.join(attributes)})")
        return f"#{len(self._lines)}"

    def add_all(self, file: str, /, **values: str) -> None:
        """The entities of an asset, whose numbers there stand in ``at``."""
        lines = asset(file).splitlines()
        at = range(len(self._lines) + 1, len(self._lines) + len(lines) + 1)
        self._lines += [line.format(at=at, **values) for line in lines]

    def lines(self) -> Iterable[str]:
        """The data section."""
        return (f"#{i}={text};" for i, text in enumerate(self._lines, start=1))


def exchange_file(design: Provenance, title: str, data: Iterable[str]) -> bytes:
    """A whole file, which says what made it and from which design."""
    file = asset("exchange.step").format(
        title=text(title),
        origin=text(f"design {design.id}"),
        name=text(design.name or design.id),
        time=NO_TIME,
        version=text(f"Camwright {design.engine_version}"),
        schema=text(SCHEMA),
        data="\n".join(data),
    )
    return file.encode("ascii")


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


def entity(data: Entities, kind: str, vector: Array) -> str:
    """Writes a point or a direction; returns the reference."""
    return data.add(kind, "''", many(map(real, vector.tolist())))


def write_spline(data: Entities, name: str, spline: NdBSpline, closed: str = ".F.") -> str:
    """Writes a B-spline curve or surface; returns the reference."""

    def net(part: Array) -> str:
        return entity(data, "CARTESIAN_POINT", part) if part.ndim == 1 else many(map(net, part))

    each = [np.unique(axis, return_counts=True) for axis in spline.t]
    return data.add(
        f"B_SPLINE_{'CURVE' if len(each) == 1 else 'SURFACE'}_WITH_KNOTS", name,
        *map(str, spline.k), net(spline.c), ".UNSPECIFIED.", closed, *[".F."] * len(each),
        *(many(map(str, times.tolist())) for _, times in each),
        *(many(map(real, axis.tolist())) for axis, _ in each), ".UNSPECIFIED.",
    )  # fmt: skip


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
    data.add_all("context.step", uncertainty=real(max(error, FINEST)), meaning=text(meaning))
    label = text(name or design.name or f"cam {design.id}")
    shape = data.add(kind, label, many([PLACED, write(data)]), CONTEXT)
    data.add_all(
        "product.step",
        id=text(design.id),
        name=text(design.name or "cam"),
        made=text(f"Camwright {design.engine_version}, design {design.id}"),
        shape=shape,
    )
    return exchange_file(design, title, data.lines())


def _profile(design: Design, options: ExactOptions) -> FileContent:
    curve = ExactCurve.of(design, options)

    def write(data: Entities) -> str:
        name = text(curve.name)
        spline = NdBSpline((curve.spline.knots,), curve.points, (curve.spline.degree,))
        return data.add(
            "GEOMETRIC_CURVE_SET", name, many([write_spline(data, name, spline, ".T.")])
        )

    title = f"Cam curve {curve.name}, within {curve.spline.error:.2g} mm of the true curve"
    kind = "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION"
    return curve.file(shape_file(design, title, kind, write, curve.spline.error, name=curve.name))


PROFILE = design_format("profile", "step", _profile, ExactOptions)
