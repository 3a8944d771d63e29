"""CSV: a header row with units in the names, then numbers; UTF-8, LF, dot decimals.

Numbers are the shortest that read back to the same double.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.fidelity.told import table_fidelity_told
from synthesis.exporters.options import MotionOptions, ProfileOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.carried import force_columns
from synthesis.exporters.samples.columns import Column, motion_columns, profile_columns
from synthesis.exporters.samples.cutting import chosen
from synthesis.exporters.tables.shortest import WIDTH, Whole, joined, written
from synthesis.numerics.piecewise import Array

BLOCK = 1024  # rows at once: memory that stays in the cache is not fetched anew


def table(columns: Sequence[Column]) -> bytes:
    """A header row, then the columns' values."""
    header = ",".join(column.name for column in columns)
    rows = len(columns[0].values)
    parts = [header.encode(), b"\n"]
    for start in range(0, rows, BLOCK):
        values = [column.values[start : start + BLOCK] for column in columns]
        parts.append(_lines(values))
    return b"".join(parts)


def _lines(values: Sequence[Array | Whole]) -> bytes:
    real = [k for k, each in enumerate(values) if each.dtype.kind == "f"]
    rows = len(values[0])
    cells = np.full((rows, len(values), WIDTH + 1), ord(","), dtype=np.uint8)
    numbers = np.column_stack([values[k] for k in real]).ravel()
    texts = written(np.asarray(numbers, dtype=float))
    cells[:, real, :-1] = texts.reshape(rows, len(real), WIDTH)
    for k, each in enumerate(values):
        if k not in real:
            cells[:, k, :-1] = written(each)
    cells[:, -1, -1] = ord("\n")
    return joined(cells)


def _profile(design: Design, options: ProfileOptions) -> bytes:
    return table(profile_columns(chosen(design, options), options))


def _motion(design: Design, options: MotionOptions) -> bytes:
    cam = Cam.of(design)
    return table([*motion_columns(cam, options), *force_columns(design, cam, options)])


_TITLE, _MEDIA = "Table, comma separated", "text/csv; charset=utf-8; header=present"
PROFILE = Exporter(
    "csv", _TITLE, _MEDIA, ".csv", _profile, ProfileOptions, measure=table_fidelity_told
)
MOTION = Exporter("csv", _TITLE, _MEDIA, ".csv", _motion, MotionOptions)
