"""The motion of a shaper as a table: CSV, and JSON with what each column means."""

from __future__ import annotations

import json

from synthesis.exporters.exporter import untold
from synthesis.exporters.linkages.file import LinkageFile
from synthesis.exporters.linkages.shaper_rows import Rows
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.tables.csv_table import table
from synthesis.linkages.shaper import SixBarShaper


def _rows(found: SixBarShaper, options: MotionOptions) -> Rows:
    return Rows.of(found, max(36, round(options.count)))


def _csv(found: SixBarShaper, options: MotionOptions) -> bytes:
    return table(_rows(found, options).columns())


def _json(found: SixBarShaper, options: MotionOptions) -> bytes:
    columns = _rows(found, options).columns()
    body = {
        "kind": "shaper motion",
        "shaper": {"id": found.id, "name": found.name, "status": found.status},
        "dimensions": found.dimensions,
        "rotation": found.spec.rotation,
        "rows": len(columns[0].values),
        "columns": [
            {"name": c.name, "unit": c.unit, "meaning": c.meaning, "values": c.values.tolist()}
            for c in columns
        ],
    }
    return json.dumps(body, ensure_ascii=False, allow_nan=False).encode() + b"\n"


CSV = LinkageFile(
    "motion.csv",
    "Table of the motion",
    "text/csv; charset=utf-8; header=present",
    ".csv",
    untold(_csv),
    MotionOptions,
)
JSON = LinkageFile(
    "motion.json",
    "Table of the motion, with units and meanings",
    "application/json",
    ".json",
    untold(_json),
    MotionOptions,
)
