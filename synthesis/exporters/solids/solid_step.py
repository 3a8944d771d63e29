"""STEP AP242: the cam as a solid with bore, keyway and hub. Needs the extra ``cad``."""

from __future__ import annotations

from importlib.util import find_spec

from synthesis.design.design import Design
from synthesis.errors import ExtraMissing
from synthesis.exporters.curves.step import exchange_file, text
from synthesis.exporters.exporter import FileContent, design_format
from synthesis.exporters.solids.blank import SolidOptions, blank


def _solid(design: Design, options: SolidOptions) -> FileContent:
    planned = blank(design, options)
    if find_spec("OCP") is None:
        raise ExtraMissing("A solid", "cad")
    try:
        from synthesis.exporters.solids.body import data_lines, solid
    except ImportError as error:  # its wheels bring all but OpenGL, which containers may lack
        raise ExtraMissing("A solid", "cad", f"{error}; on Debian: apt install libgl1") from error

    lines = data_lines(solid(planned), text(design.name or f"cam {design.id}"))
    title = f"Cam, flanks within {planned.error:.2g} mm of the true curve"
    facts = {"Curve-Error-Mm": f"{planned.error:.3g}", "Volume-Mm3": repr(planned.volume)}
    return FileContent(exchange_file(design, title, lines), facts)


SOLID = design_format("solid", "step", _solid, SolidOptions)
