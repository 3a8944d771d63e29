"""A file of a design in any format."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import Exporter, form
from synthesis.exporters.options import ProfileOptions

COARSE = {"points": 180, "width_px": 200}  # whatever a file holds, it is written alike with more


def coarse(exporter: Exporter[Any]) -> Any:
    """Options with few points or pixels where a format has any, and else as they come."""
    fields = form(exporter.options).model_fields
    return exporter.options(**{name: size for name, size in COARSE.items() if name in fields})


def written(exporter: Exporter[Any], design: Design, options: Any = None) -> bytes:
    """The file with default options; with a tool where the format refuses to guess one."""
    options = exporter.options() if options is None else options
    with suppress(InputError):
        return exporter.write(design, options)
    with pytest.raises(InputError, match="cutter_diameter_mm"):
        exporter.write(design, options)
    cutter = ProfileOptions(curve="cutter", cutter_diameter_mm=8.0, points=options.points)
    return exporter.write(design, exporter.options_like(cutter))
