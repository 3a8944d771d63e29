"""A file of a design in any format."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest

from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.options import ProfileOptions


def written(exporter: Exporter[Any], design: Design) -> bytes:
    """The file with default options; with a tool where the format refuses to guess one."""
    with suppress(InputError):
        return exporter.write(design, exporter.options())
    with pytest.raises(InputError, match="cutter_diameter_mm"):
        exporter.write(design, exporter.options())
    cutter = ProfileOptions(curve="cutter", cutter_diameter_mm=8.0)
    return exporter.write(design, exporter.options_like(cutter))
