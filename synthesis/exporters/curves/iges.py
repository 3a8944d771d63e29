"""IGES 5.3: one rational B-spline curve (entity 126), in mm.

Records of 80 columns: 72 (64 of parameters) of text, a section's letter, a number. Sections: start
(S), global (G), directory (D, two records an entity), parameters (P), and how many of each (T).
"""

from __future__ import annotations

from synthesis.design.design import Design
from synthesis.exporters.curves.exact import FINEST, ExactCurve, ExactOptions
from synthesis.exporters.curves.step import real
from synthesis.exporters.exporter import FileContent, design_format

NO_TIME = "19800101.000000"  # the same design, the same bytes: no clock
TEXT, DATA = 72, 64  # columns
SPLINE = 126  # entity type: rational B-spline curve
MILLIMETRES, IGES_5_3, ISO = 2, 11, 0  # codes of the global section


def _profile(design: Design, options: ExactOptions) -> FileContent:
    curve = ExactCurve.of(design, options)
    sentence = _ascii(
        f"Cam curve {curve.name} of design {design.id}, made by Camwright {design.engine_version}, "
        f"within {curve.spline.error:.2g} mm of the true curve"
    )
    start = _records([sentence[i : i + TEXT] for i in range(0, len(sentence), TEXT)], "S")
    whole = _records(_packed(_globals(design, curve), TEXT), "G")
    parameters = _packed(_parameters(curve), DATA)
    data = _records([f"{line:<{DATA}}{1:>8}" for line in parameters], "P")
    directory = _records(_directory(curve, len(data)), "D")
    sections = {"S": start, "G": whole, "D": directory, "P": data}
    counts = "".join(f"{letter}{len(lines):>7}" for letter, lines in sections.items())
    lines = [*start, *whole, *directory, *data, *_records([counts], "T")]
    return curve.file("".join(lines).encode("ascii"))


def _globals(design: Design, curve: ExactCurve) -> list[str]:
    """Parameters 1 to 26 of the global section."""
    maker = _string(f"Camwright {design.engine_version}")
    largest = float(abs(curve.points).max())
    return [
        "1H,", "1H;", _string(design.id), _string(f"{curve.name}.igs"), maker, maker,
        "32", "308", "15", "308", "15", _string(design.name or design.id),
        "1.", str(MILLIMETRES), "2HMM", "1", "0.1", _string(NO_TIME),
        real(max(curve.spline.error, FINEST)), real(largest), "", "",
        str(IGES_5_3), str(ISO), _string(NO_TIME), "",
    ]  # fmt: skip


def _parameters(curve: ExactCurve) -> list[str]:
    """Of the entity: plane, closed, polynomial, not periodic; knots, weights, points, normal."""
    spline = curve.spline
    points = curve.points
    return [
        str(SPLINE), str(len(points) - 1), str(spline.degree), "1", "1", "1", "0",
        *map(real, spline.knots.tolist()),
        *["1."] * len(points),
        *map(real, points.ravel().tolist()),
        real(spline.knots[0]), real(spline.knots[-1]), "0.", "0.", "1.",
    ]  # fmt: skip


def _directory(curve: ExactCurve, lines: int) -> list[str]:
    """Two records: fields of eight columns each, right-justified."""
    first = (SPLINE, 1, 0, 1, 0, 0, 0, 0, "00000000")
    label = _ascii(curve.name).upper().replace("_", "")[:8]
    second = (SPLINE, 0, 0, lines, 0, "", "", label, 1)
    return ["".join(f"{field:>8}" for field in fields) for fields in (first, second)]


def _packed(values: list[str], width: int) -> list[str]:
    """Values with commas between and a semicolon at the end; no value but a string is split."""
    lines, line = [], ""
    for k, value in enumerate(values):
        piece = value + (";" if k == len(values) - 1 else ",")
        if len(line) + len(piece) > width:
            lines.append(line)
            line = ""
        while len(piece) > width:  # strings only
            lines.append(piece[:width])
            piece = piece[width:]
        line += piece
    return [*lines, line]


def _records(lines: list[str], letter: str) -> list[str]:
    return [f"{line:<{TEXT}}{letter}{k:>7}\n" for k, line in enumerate(lines, start=1)]


def _string(value: str) -> str:
    plain = _ascii(value)
    return f"{len(plain)}H{plain}"


def _ascii(value: str) -> str:
    """What a reader of 1996 can take."""
    return "".join(letter if " " <= letter <= "~" else "?" for letter in value)


PROFILE = design_format("profile", "igs", _profile, ExactOptions)
