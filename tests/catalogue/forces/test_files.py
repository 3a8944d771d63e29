"""Forces in tables and diagrams."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from synthesis import Design
from synthesis.exporters import MOTION_FORMATS, PICTURES, MotionOptions, PictureOptions
from tests.catalogue.forces.test_limited import columns, measured, pressed  # noqa: F401


def test_tables_of_the_motion_hold_the_forces(pressed: Design) -> None:  # noqa: F811
    table, found = columns(pressed), measured(pressed)
    for name, wanted in (
        ("contact_force_n", "force"), ("hertz_pressure_mpa", "pressure"), ("torque_n_m", "torque"),
    ):  # fmt: skip
        at = np.interp(found["theta"], table["theta_deg"], table[name])
        sound = np.isfinite(found[wanted])
        assert np.median(np.abs(at - found[wanted])[sound]) < 1e-4 * np.abs(table[name]).max()
    body = json.loads(MOTION_FORMATS["json"].write(pressed, MotionOptions()))
    units = {column["name"]: column["unit"] for column in body["columns"]}
    assert units["drive_n"] == "N"
    assert units["torque_n_m"] == "N m"
    assert units["hertz_pressure_mpa"] == "MPa"


def test_the_contact_sheet_shows_them_with_their_limits(pressed: Design) -> None:  # noqa: F811
    root = ET.fromstring(PICTURES["contact.svg"].write(pressed, PictureOptions()))
    words = [text.text or "" for text in root.iter() if text.tag.endswith("text")]
    for title in ("Contact force N, N", "Hertz pressure p, MPa", "Camshaft torque T, N m"):
        assert title in words
    (reported,) = [word for word in words if "limit 700" in word]
    assert any(f"max {most}" in reported for most in ("699.8", "699.9", "700"))


def test_without_a_load_nothing_is_told(pressed: Design) -> None:  # noqa: F811
    body = pressed.model_dump(mode="json")
    body["spec"] |= {"load": None, "limits": body["spec"]["limits"][:2]}
    plain = Design.model_validate(body)
    assert b"drive_n" not in MOTION_FORMATS["csv"].write(plain, MotionOptions())
    assert b"Contact force" not in PICTURES["contact.svg"].write(plain, PictureOptions())


@pytest.mark.parametrize("value", [-3.0, 0.0])
def test_a_flank_that_is_not_pressed_bears_no_pressure(pressed: Design, value: float) -> None:  # noqa: F811
    machine = pressed.completed_spec.machine()
    from synthesis.catalogue.forces.reduced import pressure_square

    found = pressure_square(machine.load, machine.follower.flanks[0], value, 0.01)
    assert found <= 0.0
