"""The timing of a set, against a count on a fine grid and by hand."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from synthesis import CamSet, synthesise_set
from tests.studies.cam_sets import INLET, body, question


@pytest.fixture(scope="module")
def found() -> CamSet:
    return synthesise_set(question())


def speeds(found: CamSet, shaft_deg: np.ndarray) -> np.ndarray:
    """ds/dθ of every follower (cams, n), from the finished motions."""
    return np.array(
        [cam.design.curve.derivatives(np.radians(shaft_deg - cam.phase_deg))[1]
         for cam in found.cams]
    )  # fmt: skip


def test_events_by_hand(found: CamSet) -> None:
    """Inlet: 37.9 and its angles on; press: −143.2 + 360 = 216.8 and its angles on."""
    reported = [(e.shaft_deg, e.cam, e.ends, e.starts) for e in found.timing.events]
    assert reported == [
        (37.9, 0, "dwell", "rise"),
        (109.2, 0, "rise", "dwell"),
        (111.8, 1, "return", "dwell"),
        (133.8, 0, "dwell", "return"),
        (216.8, 1, "dwell", "dwell"),
        (222.2, 0, "return", "dwell"),
        (249.9, 1, "dwell", "rise"),
        (351.8, 1, "rise", "return"),
    ]


def test_arcs_cover_the_turn_once(found: CamSet) -> None:
    arcs = found.timing.arcs
    assert sum(arc.angle_deg for arc in arcs) == pytest.approx(360.0, abs=1e-6)
    for arc, following in itertools.pairwise(arcs):
        assert arc.start_deg + arc.angle_deg == pytest.approx(following.start_deg, abs=1e-6)
        assert arc.moving != following.moving


def test_who_moves_is_who_has_a_velocity(found: CamSet) -> None:
    """Every follower moves inside of its arcs, and none outside."""
    for arc in found.timing.arcs:
        inside = arc.start_deg + arc.angle_deg * (np.arange(200) + 0.5) / 200
        moves = np.max(np.abs(speeds(found, inside)), axis=1) > 1e-9
        assert np.flatnonzero(moves).tolist() == arc.moving, arc


def test_overlap_by_hand(found: CamSet) -> None:
    """The press moves from 249.9° over the turn's end to 111.8°, the inlet twice."""
    both = [arc for arc in found.timing.arcs if len(arc.moving) > 1]
    assert [(arc.start_deg, arc.angle_deg) for arc in both] == [(37.9, 71.3)]


def test_events_do_not_run_over_the_turn() -> None:
    cams = body()["cams"]
    cams[0] |= {"phase_deg": 360.0 - 71.3 - 24.6 - 88.4}  # the return ends at 360°
    found = synthesise_set(question(cams=cams))
    ends = [e.shaft_deg for e in found.timing.events if e.cam == 0 and e.ends == "return"]
    assert ends == [0.0]


def test_one_cam_has_arcs_too() -> None:
    found = synthesise_set(question(cams=[{"phase_deg": 10.0, "spec": INLET}]))
    reported = [(arc.start_deg, arc.angle_deg, arc.moving) for arc in found.timing.arcs]
    assert reported == [(10.0, 71.3, [0]), (81.3, 24.6, []), (105.9, 88.4, [0]), (194.3, 175.7, [])]


def test_a_cam_for_which_nothing_fits_takes_no_part() -> None:
    cams = body()["cams"]
    cams[1] = {
        "name": "too steep",
        "spec": cams[1]["spec"]
        | {
            "base_radius_mm": {"max": 20},
            "limits": [{"kind": "pressure_angle", "rise_deg": 5, "return_deg": 5}],
        },
    }
    found = synthesise_set(question(cams=cams))
    assert [cam.design.status for cam in found.cams] == ["optimal", "infeasible"]
    assert found.status == "infeasible"
    assert found.has_cams
    assert {event.cam for event in found.timing.events} == {0}
