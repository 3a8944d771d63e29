"""Forces of a finished cam: what does not depend on where the turn begins, and square roots."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from synthesis.catalogue.motion import Motion
from synthesis.certify import report_forces
from synthesis.certify.force_report import _square_root
from synthesis.design.design import FloatArc, ForcePeak, Forces
from synthesis.spec.design_spec import DesignSpec

HARMONIC = {"kind": "simple_harmonic"}
RISE, RETURN = (
    {"kind": kind, "angle_deg": angle, "lift_mm": 21.3, "law": HARMONIC}
    for kind, angle in (("rise", 71.3), ("return", 83.9))
)
DWELL = {"kind": "dwell", "angle_deg": 360.0 - 71.3 - 83.9}


def forces(rpm: float, program: list[dict[str, Any]], **load: Any) -> Forces:
    """Of a roller without offset at a prime radius of 38 mm."""
    spec = DesignSpec.model_validate({
        "speed_rpm": rpm, "program": program, "base_radius_mm": 31.0, "limits": [],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 7.0, "offset_mm": 0.0},
        "load": {"kind": "slide", "moving_mass_kg": 1.9,
                 "spring": {"rate_n_per_mm": 4.3, "preload_n": 90.0}, **load},
    })  # fmt: skip
    found = report_forces(Motion.of(spec.placed_segments()), spec.machine(), (0.0, 38.0))
    assert found is not None
    return found


def test_a_short_thrust_late_in_the_turn_is_in_the_peak() -> None:
    """In a dwell the cam bears the preload and what the process adds."""
    points = [{"angle_deg": angle, "force_n": force}
              for angle, force in ((340.0, 0.0), (341.0, 500.0), (342.0, 0.0))]  # fmt: skip
    (flank,) = forces(60.0, [RISE, RETURN, DWELL], process=points).flanks
    assert flank.largest_n is not None
    assert flank.largest_n.value == pytest.approx(590.0, rel=1e-9)
    assert flank.largest_n.angle_deg == pytest.approx(341.0, abs=1e-6)


def test_the_speed_of_lift_off_is_that_at_which_inertia_is_all_that_holds() -> None:
    """At the top a ω² of the rise's end draws, spring and preload hold; a damper has no part."""
    bend = 0.5 * math.pi**2 * 0.0213 / math.radians(71.3) ** 2
    least = math.sqrt((4.3 * 21.3 + 90.0) / (1.9 * bend)) * 30.0 / math.pi
    assert forces(60.0, [RISE, RETURN, DWELL]).float_onset_rpm == pytest.approx(least, rel=1e-5)
    # drawn off by the process even at rest
    points = [{"angle_deg": angle, "force_n": -200.0} for angle in (250.0, 300.0)]
    assert forces(60.0, [RISE, RETURN, DWELL], process=points).float_onset_rpm == 0.0


def floats(program: list[dict[str, Any]], turned: float) -> list[FloatArc]:
    """Arcs of lift-off, by cam angles from the beginning of the rise."""
    found = forces(700.0, program)
    return [
        arc.model_copy(update={name: (getattr(arc, name) - turned) % 360.0 for name in
                               ("start_deg", "end_deg", "angle_deg")})
        for arc in found.floats
    ]  # fmt: skip


def test_arcs_of_lift_off_do_not_depend_on_where_the_turn_begins() -> None:
    """At the top, where rise and return meet, inertia is largest: there the second turn begins."""
    (arc,) = floats([RISE, RETURN, DWELL], 0.0)
    (same,) = floats([RETURN, DWELL, RISE], 360.0 - 71.3)
    assert arc.start_deg < 71.3 < arc.end_deg
    for name in ("start_deg", "end_deg", "lowest_n"):
        assert getattr(same, name) == pytest.approx(getattr(arc, name), abs=1e-6)
    # at the top the pressure angle is 0: inertia of the rise's end, spring and preload
    inertia = 1.9 * 0.5 * math.pi**2 * 0.0213 / math.radians(71.3) ** 2 * (math.pi * 700 / 30) ** 2
    assert arc.lowest_n == pytest.approx(4.3 * 21.3 + 90.0 - inertia, abs=1e-3)


def test_the_root_of_an_enclosed_square_is_as_wide_as_its_ends_are_apart() -> None:
    rng = np.random.default_rng(3)
    for value, share in rng.uniform([0.1, 0.0], [90.0, 1e-3], (20, 2)).tolist():
        width = share * value
        root = _square_root(ForcePeak(value=value, angle_deg=7.0, width=width))
        apart = math.sqrt(value + 0.5 * width) - math.sqrt(value - 0.5 * width)
        assert root.value**2 == pytest.approx(value)
        assert root.width == pytest.approx(apart, rel=1e-5)
    for value in (0.0, -1e-9):  # of a flank that nothing presses
        root = _square_root(ForcePeak(value=value, angle_deg=7.0, width=0.04))
        assert (root.value, root.width) == (0.0, pytest.approx(0.2))
