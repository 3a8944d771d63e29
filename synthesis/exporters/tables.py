"""Columns as CSV, as JSON with units and metadata, and as plain rows of numbers.

In: columns (``samples.columns``). Out: bytes; numbers are the shortest decimal text that reads back
to the same double, whole columns at once. The text is Python's ``repr``, which takes half a
microsecond a number and so would take longer than everything else in a file. Here 17 digits are
found exactly: for 1e-4 ≤ |x| < 1e16 the power of ten that makes x a number of 17 digits is itself a
double, and the product of two doubles is a sum of two doubles (Dekker 1971). Fewer digits do if
they stay within half the spacing of doubles at x. (Below a power of two doubles stand twice as
close; a test goes through all of them in the range.) What lies outside of that range is rare in a
table and left to ``repr``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter, compact_json
from synthesis.exporters.fidelity.report import (
    MAX_ROWS,
    as_points,
    fidelity_block,
    fidelity_header,
)
from synthesis.exporters.options import CurveOptions, MotionOptions, ProfileOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import (
    Column,
    force_columns,
    motion_columns,
    profile_columns,
)
from synthesis.exporters.samples.cutting import checked_cam
from synthesis.exporters.samples.sampling import in_degrees, written_points
from synthesis.numerics.piecewise import Array

BLOCK = 1024  # rows at once: memory that stays in the cache is not fetched anew
FRAME = (
    "Cam-fixed, right-handed, lengths in mm: origin on the cam's axis, which is z; at cam angle 0 "
    "the machine's frame, y along the follower of an upward slide. Seen with z towards the viewer "
    "the cam turns {turns}; the rows run round it {runs}.{placed}"
)
TURNED = " The points are turned from there by {turn:.12g}° about z, counter-clockwise positive."


def csv_table(columns: Sequence[Column]) -> bytes:
    """A header row with units in the names, then numbers; UTF-8, LF, dot decimals."""
    parts = [",".join(column.name for column in columns).encode(), b"\n"]
    real = [k for k, each in enumerate(columns) if each.values.dtype.kind == "f"]
    for start in range(0, len(columns[0].values), BLOCK):
        values = [column.values[start : start + BLOCK] for column in columns]
        rows = len(values[0])
        cells = np.full((rows, len(values), WIDTH + 1), ord(","), dtype=np.uint8)
        numbers = np.column_stack([values[k] for k in real]).ravel()
        texts = to_text(np.asarray(numbers, dtype=float))
        cells[:, real, :-1] = texts.reshape(rows, len(real), WIDTH)
        for k in set(range(len(values))).difference(real):
            cells[:, k, :-1] = to_text(values[k])
        cells[:, -1, -1] = ord("\n")
        parts.append(join_cells(cells))
    return b"".join(parts)


def json_table(body: dict[str, Any], columns: Sequence[Column]) -> bytes:
    """A document with the columns at its end."""
    inside = b",".join(_json_column(column) for column in columns)
    return compact_json(body)[:-1] + b',"columns":[' + inside + b"]}\n"


def _json_column(column: Column) -> bytes:
    head = {
        "name": column.name,
        "unit": column.unit,
        "type": "integer" if column.values.dtype.kind == "i" else "number",
        "meaning": column.meaning,
    }
    cells = np.full((len(column.values), WIDTH + 1), ord(","), dtype=np.uint8)
    # JSON has no infinity: null where the value is infinite
    cells[:, :-1] = to_text(column.values, infinite="null")
    return compact_json(head)[:-1] + b',"values":[' + join_cells(cells)[:-1] + b"]}"


@dataclass(frozen=True)
class JsonOptions(CurveOptions):
    """As ``ProfileOptions``, and what else stands in the file."""

    fidelity: Annotated[
        bool,
        Field(
            description="Say what straight lines and splines through the curve's points, taken "
            "once round as for point files and not rounded, do to the form and to the follower's "
            f"acceleration. Left out of more than {MAX_ROWS} points."
        ),
    ] = True


def origin(design: Design) -> dict[str, Any]:
    """Which design a file is of, and whether it is certified."""
    return {
        "id": design.id,
        "name": design.name,
        "engine_version": design.engine_version,
        "status": design.status,
        "certified": design.certificate.certified,
    }


def _json_profile(design: Design, options: JsonOptions) -> bytes:
    cam = checked_cam(design, options)
    turns = ("counter-clockwise", "clockwise")
    turns = turns if design.rotation == "ccw" else turns[::-1]
    placed = TURNED.format(turn=options.turn_deg) if options.turn_deg else ""
    head = {
        "kind": "profile",
        "curve": options.curve,
        "frame": FRAME.format(turns=turns[0], runs=turns[1], placed=placed),
        "seam_deg": float(in_degrees(np.array(cam.seam))),
    }
    if options.fidelity:
        unrounded = as_points(options)
        points = written_points(cam, unrounded)
        if len(points.theta) <= MAX_ROWS:
            head["fidelity"] = fidelity_block(cam, points, unrounded)
    return _json_file(design, head, asdict(options), profile_columns(cam, options))


def _json_motion(design: Design, options: MotionOptions) -> bytes:
    segments = [segment.model_dump(mode="json", exclude_none=True) for segment in design.motion]
    head = {"kind": "motion", "segments": segments}
    return _json_file(design, head, asdict(options), _motion_and_forces(design, options))


def _json_file(
    design: Design, head: dict[str, Any], sampling: dict[str, Any], columns: Sequence[Column]
) -> bytes:
    body = {
        **head,
        "design": origin(design),
        "rotation": design.rotation,
        "speed_rpm": design.speed_rpm,
        "follower": design.follower,
        "dimensions": design.dimensions,
        "sampling": sampling,
        "rows": len(columns[0].values),
    }
    return json_table(body, columns)


def _motion_and_forces(design: Design, options: MotionOptions) -> list[Column]:
    cam = Cam.of(design)
    return [*motion_columns(cam, options), *force_columns(design, cam, options)]


def _txt_motion(design: Design, options: MotionOptions) -> bytes:
    """For programs that read bare numbers: `numpy.loadtxt`, a spreadsheet's text import."""
    columns = [column.values.tolist() for column in motion_columns(Cam.of(design), options)]
    rows = zip(*columns, strict=True)
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows).encode("ascii")


CSV = "Table, comma separated", "text/csv; charset=utf-8; header=present", ".csv"
JSON = "Columns with units and metadata", "application/json", ".json"
CSV_PROFILE = Exporter(
    "csv", *CSV,
    lambda design, options: csv_table(profile_columns(checked_cam(design, options), options)),
    ProfileOptions, measure=lambda design, options: fidelity_header(design, as_points(options)),
)  # fmt: skip
CSV_MOTION = Exporter(
    "csv", *CSV, lambda design, options: csv_table(_motion_and_forces(design, options)),
    MotionOptions,
)  # fmt: skip
JSON_PROFILE = Exporter("json", *JSON, _json_profile, JsonOptions)
JSON_MOTION = Exporter("json", *JSON, _json_motion, MotionOptions)
TXT_MOTION = Exporter(
    "txt", "Table, space separated, no header: the columns of csv in their order",
    "text/plain; charset=us-ascii", ".txt", _txt_motion, MotionOptions,
)  # fmt: skip


Cells = NDArray[np.uint8]
Whole = NDArray[np.int64]

LEAST, MOST = 1e-4, 1e15  # between these, texts are written in full and found here
FILL = 7  # zeros before the first of the 17 digits, enough for 0.0001
PLACES = np.arange(FILL + 17)
WIDTH = 1 + len(PLACES) + 1  # sign, digits, point
SPLITTER = 2.0**27 + 1.0  # splits a double into two halves (Veltkamp)
TENS = np.array([float(10**k) for k in range(23)])  # exact
ZERO, POINT, MINUS = 48, 46, 45  # ASCII codes of "0", "." and "-"
# The four digits of 0 to 9999, as one word each.
DIGITS = np.arange(10000)[:, None] // np.array([1000, 100, 10, 1]) % 10 + ZERO
FOUR = DIGITS.astype(np.uint8).view(np.uint32)[:, 0]


def to_text(values: Array | Whole, infinite: str = "inf") -> Cells:
    """Texts in ASCII, (n, WIDTH); a zero byte is no character, wherever it stands.

    Args:
        values: (n,) numbers; of whole numbers no digit is lost either.
        infinite: what to write for +∞ (−∞ is not expected).
    """
    if values.dtype.kind == "i":
        return _bytes(values.astype(f"S{WIDTH}"))
    magnitude = np.abs(values)
    usual = (magnitude >= LEAST) & (magnitude < MOST)
    cells = np.zeros((len(values), WIDTH), dtype=np.uint8)
    cells[usual] = _usual(np.asarray(values[usual], dtype=float))
    cells[values == 0.0, :3] = ZERO, POINT, ZERO
    rest = np.flatnonzero(~usual & (values != 0.0))
    if len(rest):
        texts = [repr(value).replace("inf", infinite) for value in values[rest].tolist()]
        cells[rest] = _bytes(np.array(texts, dtype=f"S{WIDTH}"))
    return cells


def join_cells(cells: Cells) -> bytes:
    """All characters, row by row."""
    return cells.tobytes().translate(None, b"\0")


def _bytes(texts: NDArray[np.bytes_]) -> Cells:
    return np.frombuffer(texts.tobytes(), dtype=np.uint8).reshape(len(texts), WIDTH)


def _usual(values: Array) -> Cells:
    number, exponent = _digits(np.abs(values))
    units = FILL + exponent  # place of the digit before the point
    first = np.minimum(units, FILL)
    last = np.maximum(FILL + 16 - _end_zeros(number), units + 1)
    seen = (first[:, None] <= PLACES) & (last[:, None] >= PLACES)
    digits = _characters(number) * seen
    cells = np.zeros((len(values), WIDTH), dtype=np.uint8)
    cells[:, 2:] = digits  # as they stand behind the point, and then before it
    np.copyto(cells[:, 1:-1], digits, where=units[:, None] >= PLACES)
    cells[np.arange(len(values)), units + 2] = POINT
    cells[:, 0] = (values < 0.0) * np.uint8(MINUS)
    return cells


def _digits(x: Array) -> tuple[Whole, Whole]:
    """Shortest digits of x > 0, filled with zeros to a number of 17; and floor(log10 x)."""
    exponent = np.floor(np.log10(x)).astype(np.int64)
    high = x * TENS[16 - exponent]
    exponent += (high >= 1e17).astype(np.int64) - (high < 1e16).astype(np.int64)
    power = TENS[16 - exponent]
    high, low = _product(x, power)
    near = np.rint(low)
    number = high.astype(np.int64) + near.astype(np.int64)
    rest = low - near
    room = 0.5 * np.spacing(x) * power
    best = number
    for scale in (10, 100):
        quotient = number // scale
        over = (number - quotient * scale) + rest
        up = (over > 0.5 * scale) | ((over == 0.5 * scale) & (quotient % 2 == 1))
        fits = np.abs(over - scale * up) < room
        best = np.where(fits, (quotient + up) * scale, best)
    return best, exponent


def _product(a: Array, b: Array) -> tuple[Array, Array]:
    """a b as a sum of two doubles, exactly (Dekker)."""
    a_high, b_high = _upper(a), _upper(b)
    a_low, b_low = a - a_high, b - b_high
    high = a * b
    return high, ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low


def _upper(a: Array) -> Array:
    """The upper half of a double's digits."""
    scaled = SPLITTER * a
    return scaled - (scaled - a)


def _end_zeros(number: Whole) -> Whole:
    """How many zeros each number ends with."""
    count = np.zeros_like(number)
    rows, rest = np.arange(len(number)), number
    while len(rows):
        ends = rest % 10 == 0
        rows, rest = rows[ends], rest[ends] // 10
        count[rows] += 1
    return count


def _characters(number: Whole) -> Cells:
    """The 17 digits of each number in ASCII behind FILL zeros: (n, FILL + 17)."""
    words = np.empty((len(number), 6), dtype=np.uint32)
    words[:, 0] = FOUR[0]
    high = number // 10**8
    low = (number - high * 10**8).astype(np.uint32)
    top = (high // 10**8).astype(np.uint32)
    middle = (high - top * np.int64(10**8)).astype(np.uint32)
    words[:, 1] = FOUR[top]
    for k, eight in ((2, middle), (4, low)):
        upper = eight // np.uint32(10000)
        words[:, k] = FOUR[upper]
        words[:, k + 1] = FOUR[eight - upper * np.uint32(10000)]
    return words.view(np.uint8)
