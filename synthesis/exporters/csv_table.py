"""CSV: a header row with units in the names, then numbers; UTF-8, LF, dot decimals.

Numbers are the shortest that read back to the same double.
"""

from __future__ import annotations

from collections.abc import Sequence

from synthesis.design import Design
from synthesis.exporters.cam import Cam
from synthesis.exporters.columns import Column, motion_columns, profile_columns
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import MotionOptions, ProfileOptions


def _written(columns: Sequence[Column]) -> bytes:
    header = ",".join(column.name for column in columns)
    cells = [map(repr, column.values.tolist()) for column in columns]
    return "\n".join([header, *map(",".join, zip(*cells, strict=True)), ""]).encode()


def _profile(design: Design, options: ProfileOptions) -> bytes:
    return _written(profile_columns(Cam.of(design), options))


def _motion(design: Design, options: MotionOptions) -> bytes:
    return _written(motion_columns(Cam.of(design), options))


_TITLE, _MEDIA = "Table, comma separated", "text/csv; charset=utf-8; header=present"
PROFILE = Exporter("csv", _TITLE, _MEDIA, ".csv", _profile)
MOTION = Exporter("csv", _TITLE, _MEDIA, ".csv", _motion)
