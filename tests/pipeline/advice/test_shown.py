"""A stop stands beside the status wherever a status is shown."""

from __future__ import annotations

import json

import pytest

from service.commands.tables import describe_analysis, describe_cam_set, describe_design
from synthesis import CamSetSpec, DesignSpec, analyse, synthesise, synthesise_set
from synthesis.design.design import Design
from synthesis.design.warnings import DesignWarning
from synthesis.exporters import PICTURES, PictureOptions
from tests.pipeline.advice.bad_cams import FIRST, cam, program

SHAKEN = FIRST["float"][2]  # optimal, and yet the follower leaves its cam


@pytest.fixture(scope="module")
def design() -> Design:
    return synthesise(DesignSpec.model_validate(SHAKEN))


def test_the_answer_has_the_severity_beside_the_status(design: Design) -> None:
    body = json.loads(design.model_dump_json())
    names = list(body)
    assert body["status"] == "optimal"
    assert names[names.index("status") + 1 :][:2] == ["severity", "warnings"]
    assert body["severity"] == body["warnings"][0]["severity"] == "stop"
    assert "status='optimal', severity='stop'" in repr(design)


def test_the_report_says_stop_and_escapes_what_it_says(design: Design) -> None:
    nasty = DesignWarning(
        code="x", severity="note", field="y", sentence="<b>", remedy="&", source='"'
    )
    shown = design.model_copy(update={"warnings": [*design.warnings, nasty]})
    page = PICTURES["report.html"].write(shown, PictureOptions()).decode()
    assert "<strong>optimal, but STOP</strong>" in page
    assert design.warnings[0].sentence in page
    assert "<b>" not in page
    assert "&lt;b&gt;" in page


def test_the_terminal_says_stop_in_its_first_line(design: Design) -> None:
    first, second, *_ = describe_design(design, 0.1)
    assert str(first).startswith("optimal, but STOP")
    assert str(second).startswith("  STOP (contact_force, load/spring): The follower leaves its")


def test_a_cam_set_is_as_bad_as_its_worst_cam() -> None:
    bodies = [cam(70.0), SHAKEN]
    shaft = {"speed_rpm": SHAKEN["speed_rpm"]}
    cams = [{"spec": {k: v for k, v in body.items() if k != "speed_rpm"}} for body in bodies]
    found = synthesise_set(CamSetSpec.model_validate({**shaft, "cams": cams}))
    assert (found.status, found.severity) == ("optimal", "stop")
    first, _, second, *_ = describe_cam_set(found)
    assert first.startswith("optimal, but STOP")
    assert "optimal, but STOP" in second


def test_a_given_cam_is_judged_too() -> None:
    body = cam(70.0, speed_rpm=300.0, program=program(law="simple_harmonic"))
    found = analyse(DesignSpec.model_validate(body))
    assert (found.holds, found.severity) == (True, "caution")
    lines = [line for line in describe_analysis(found) if isinstance(line, str)]
    assert any("caution (jumps, program/" in line for line in lines)
