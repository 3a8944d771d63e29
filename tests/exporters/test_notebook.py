"""What Jupyter shows of a design."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET

import pytest

from service.contract.examples import examples
from synthesis.design.design import Design
from synthesis.design.warnings import DesignWarning
from synthesis.pipeline.synthesise import synthesise
from synthesis.spec.design_spec import DesignSpec


def shown(design: Design) -> tuple[ET.Element, str]:
    """The page's part, which must be well formed, and the line."""
    bundle = design._repr_mimebundle_(include=None, exclude=None)
    html = re.sub(r"(<img [^>]*)>", r"\1/>", bundle["text/html"])
    return ET.fromstring(f"<div>{html}</div>"), bundle["text/plain"]


def test_a_design_is_shown_with_pictures_summary_and_warnings() -> None:
    spec = DesignSpec.model_validate({**examples()["fixed-laws"]["value"], "name": "a < b"})
    warning = DesignWarning(
        code="x", severity="stop", field="/limits", sentence="It is < 3 mm.", remedy="R.", source=""
    )
    design = synthesise(spec).model_copy(update={"warnings": [warning], "severity": "stop"})
    page, line = shown(design)
    assert line.startswith("<Design a < b: optimal, but STOP; base_radius_mm 50.888")
    text = " ".join("".join(page.itertext()).split())
    assert "a < b: optimal, but STOP, certified" in text
    assert "stop /limits: It is < 3 mm. R." in text
    assert "No cam is better by more than" in text
    pictures = [image.attrib["src"].partition(",")[2] for image in page.iter("img")]
    assert [ET.fromstring(base64.b64decode(one)).tag.rpartition("}")[2] for one in pictures] == [
        "svg", "svg",
    ]  # fmt: skip
    titles = [each.findtext("summary") for each in page.iter("details")]
    assert titles[:2] == ["Dimensions", "Motion"]
    for table in page.iter("table"):
        width = len(list(table.iter("th")))
        assert {len(row) for row in table.iter("tr")} == {width}


@pytest.mark.usefixtures("unexplained")
def test_a_question_without_a_cam_is_shown() -> None:
    value = examples()["infeasible-on-purpose"]["value"]
    page, line = shown(synthesise(DesignSpec.model_validate(value)))
    assert line.endswith(": infeasible; no cam>")
    assert "infeasible, proven: no cam keeps these limits." in "".join(page.itertext())
    assert not list(page.iter("img"))
