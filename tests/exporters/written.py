"""A file of a design in any format."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters import Exporter, form
from synthesis.exporters.options import ProfileOptions


def written(exporter: Exporter[Any], design: Design, points: int | None = None) -> bytes:
    """The file with default options; with a tool where the format refuses to guess one.

    ``points``: how many, where the format has points; by default as many as it has unasked.
    """
    pointed = points is not None and "points" in form(exporter.options).model_fields
    options = exporter.options(points=points) if pointed else exporter.options()
    with suppress(InputError):
        return exporter.write(design, options)
    with pytest.raises(InputError, match="cutter_diameter_mm"):
        exporter.write(design, options)
    cutter = ProfileOptions(curve="cutter", cutter_diameter_mm=8.0, points=points)
    return exporter.write(design, exporter.options_like(cutter))
