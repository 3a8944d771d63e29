"""What a set may ask: one shaft, and what it hands on to its cams."""

from __future__ import annotations

import json
import pickle
from typing import Any

import pytest
from pydantic import ValidationError

from synthesis import CamSetSpec, DesignSpec, synthesise, synthesise_set
from synthesis.design.cam_set import set_id
from synthesis.design.design import Design
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.exporters.bundle import folders
from synthesis.exporters.diagrams.timing import timing_diagram
from synthesis.numerics import clock
from synthesis.spec.cam_set import MAX_CAMS, within_half_turn, wrap_turn
from tests.studies.cam_sets import INLET, PRESS, body, question


def test_the_shaft_gives_speed_and_sense() -> None:
    found = question(rotation="cw")
    for cam in found.cams:
        assert (cam.spec.speed_rpm, cam.spec.rotation) == (143.7, "cw")
    assert [cam.spec.name for cam in found.cams] == ["inlet", "press"]
    default = CamSetSpec.model_validate({"cams": [{"spec": INLET}]})
    assert default.cams[0].spec.speed_rpm == default.speed_rpm


def test_given_once_more_they_say_the_same() -> None:
    explicit = body()
    for cam in explicit["cams"]:
        cam["spec"] = {"speed_rpm": 143.7, "rotation": "ccw", "name": cam["name"]} | cam["spec"]
    assert CamSetSpec.model_validate(explicit) == question()
    assert set_id(CamSetSpec.model_validate(explicit)) == set_id(question())


def test_what_was_written_is_read_again() -> None:
    """Strictly, as the service reads it."""
    text = question().model_dump_json()
    assert CamSetSpec.model_validate_json(text, strict=True) == question()
    assert CamSetSpec.model_validate_json(json.dumps(body()), strict=True) == question()


@pytest.mark.parametrize(("field", "value"), [("speed_rpm", 143.6), ("rotation", "cw")])
def test_a_cam_that_turns_otherwise_is_refused(field: str, value: Any) -> None:
    cams = body()["cams"]
    cams[1] = cams[1] | {"spec": PRESS | {field: value}}
    with pytest.raises(ValidationError, match=rf"{field} is {value} here"):
        question(cams=cams)


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "other"},
        {"speed_rpm": 100.0},
        {"rotation": "cw"},
        {"cams": body()["cams"][:1]},
        {"cams": body()["cams"][::-1]},
        {"cams": [body()["cams"][0] | {"phase_deg": 37.8}, body()["cams"][1]]},
        {"time_budget_s": 3.0},
    ],
    ids=str,
)
def test_another_question_has_another_id(changes: dict[str, Any]) -> None:
    assert set_id(question(**changes)) != set_id(question())


def test_how_many_cams() -> None:
    question(cams=[{"spec": INLET}] * MAX_CAMS)
    for cams in ([], [{"spec": INLET}] * (MAX_CAMS + 1)):
        with pytest.raises(ValidationError, match="cams"):
            question(cams=cams)


@pytest.mark.parametrize("cams", [None, 3, [3], [{"spec": 3}], [{}], {"0": {}}])
def test_what_is_no_list_of_cams(cams: Any) -> None:
    with pytest.raises(ValidationError):
        question(cams=cams)


def test_a_wrong_speed_is_told_once() -> None:
    with pytest.raises(ValidationError) as caught:
        question(speed_rpm=-3.0)
    assert [error["loc"] for error in caught.value.errors()] == [("speed_rpm",)]


def test_directions() -> None:
    assert [within_half_turn(a) for a in (-180.0, 180.0, 540.0, -179.5, 0.0, 359.0)] == [
        180.0, 180.0, 180.0, -179.5, 0.0, -1.0,
    ]  # fmt: skip
    assert [wrap_turn(a) for a in (-1e-12, 360.0, 725.5, -0.5)] == [0.0, 0.0, 5.5, 359.5]


def test_every_cam_is_the_one_that_is_designed_alone() -> None:
    found = synthesise_set(question())
    for cam, spec in zip(found.cams, question().cams, strict=True):
        alone = synthesise(DesignSpec.model_validate(spec.spec.model_dump()))
        assert cam.design.id == alone.id
        assert cam.design.model_copy(update={"report": alone.report}) == alone
    assert found.status == "optimal"
    assert found.id == set_id(question())


def test_cams_without_a_name_are_numbered() -> None:
    cams = [{"spec": INLET}, {"name": " ", "spec": PRESS | {"name": "press"}}]
    assert [cam.name for cam in synthesise_set(question(cams=cams)).cams] == ["cam 1", "press"]


# --- time and trouble -----------------------------------------------------------------------------


def slow(outcomes: dict[str, Exception | None], asked_until: list[float]) -> Any:
    """A pipeline that notes its deadlines and ends as told by the cam's name."""

    def synthesised(spec: DesignSpec, *, deadline: float) -> Design:
        asked_until.append(deadline)
        error = outcomes.get(spec.name)
        if error is not None:
            raise error
        return synthesise(spec)

    return synthesised


def test_cams_share_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    until: list[float] = []
    monkeypatch.setattr("synthesis.studies.cam_set.synthesise", slow({}, until))
    cams = [{"name": f"cam {i}", "spec": INLET} for i in range(4)]
    monkeypatch.setattr(clock, "now", lambda: 1000.0)  # no cam needs any time
    synthesise_set(question(cams=cams), deadline=1400.0)
    assert until == pytest.approx([1100.0, 1000.0 + 400.0 / 3.0, 1200.0, 1400.0])
    until.clear()
    synthesise_set(question(cams=cams, time_budget_s=40.0), deadline=1400.0)
    assert until[0] == 1010.0


def test_where_time_ends_the_best_of_all_cams_is_handed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    best = synthesise(question().cams[0].spec).model_copy(update={"status": "feasible"})
    late = slow({"inlet": TimeBudgetExceeded(1.0, best)}, [])
    monkeypatch.setattr("synthesis.studies.cam_set.synthesise", late)
    with pytest.raises(TimeBudgetExceeded) as caught:
        synthesise_set(question())
    found = pickle.loads(pickle.dumps(caught.value)).best
    assert [cam.design.status for cam in found.cams] == ["feasible", "optimal"]
    assert found.status == "feasible"


def test_where_a_cam_has_nothing_there_is_no_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "synthesis.studies.cam_set.synthesise", slow({"press": TimeBudgetExceeded(1.0)}, [])
    )
    with pytest.raises(TimeBudgetExceeded) as caught:
        synthesise_set(question())
    assert caught.value.best is None


def test_a_failed_solver_is_told_with_its_cam(monkeypatch: pytest.MonkeyPatch) -> None:
    failed = SolverFailed("clarabel", "NumericalError", "Scale the problem.")
    monkeypatch.setattr("synthesis.studies.cam_set.synthesise", slow({"press": failed}, []))
    with pytest.raises(SolverFailed, match=r"/cams/1\. Scale the problem"):
        synthesise_set(question())


def test_cams_that_share_a_name_are_told_apart_by_their_number() -> None:
    given = ["valve", "press (1)", "valve", "", "valve (3)"]
    cams = [{"name": name, "phase_deg": 20.7 * i, "spec": INLET} for i, name in enumerate(given)]
    found = synthesise_set(question(cams=cams))
    assert [cam.name for cam in found.cams] == [
        "valve (1)", "press (1)", "valve (3) (3)", "cam 4", "valve (3) (5)"
    ]  # fmt: skip
    assert [cam.name for cam in found.spec.cams] == given
    drawing = timing_diagram(found).decode()
    assert all(f">{cam.name}<" in drawing for cam in found.cams)
    assert folders(found)[2] == "03-valve-3-3"
