"""Points first, then a margin: how a law comes to keep rows between the points of these."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synthesis.optimise.separation import mesh_relaxation

MARGIN = 0.05  # that is taken where a cam breaks rows


class Law:
    def with_points(self, _: Any) -> Law:
        return self


@dataclass(frozen=True)
class State:
    margin: float
    grids: tuple[Law, ...] = (Law(),)
    time_left: float = 1.0

    def with_stage(self, _: Any) -> State:
        return self


@pytest.mark.parametrize(
    ("cams", "margins", "best"),
    [  # values of the cams, and whether they break rows; margins of their programs; the best
        ([(3.0, True), (3.1, False)], [0.0, 0.0], 3.1),
        ([(3.0, True), (3.1, True), (3.2, False)], [0.0, 0.0, MARGIN], 3.2),
        ([(3.0, False), (2.9, True), (3.1, False)], [0.0, 0.0, 0.0], 3.0),
        ([(3.0, True), (3.1, True), (3.05, True)], [0.0, 0.0, MARGIN], 3.05),
        ([(3.2, False), (3.1, False)], [0.0, 0.0], 3.1),
    ],
)
def test_points_come_first_and_the_best_cam_keeps_its_rows(
    cams: list[tuple[float, bool]], margins: list[float], best: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    used, left = list[float](), list(cams)
    broken, whole = [np.array([0.5])], [np.array([])]

    def solve_on_mesh(state: State, _: float) -> Any:
        used.append(state.margin)
        model = SimpleNamespace(problem=None, recover=lambda _: ())
        return state, model, SimpleNamespace(x=None), None

    def offer_cam(state: State, *_: Any) -> Any:
        value, breaks = left.pop(0)
        cam = SimpleNamespace(value=value)
        return (replace(state, margin=MARGIN), cam, broken) if breaks else (state, cam, whole)

    monkeypatch.setattr(mesh_relaxation, "solve_on_mesh", solve_on_mesh)
    monkeypatch.setattr(mesh_relaxation, "offer_cam", offer_cam)
    monkeypatch.setattr(mesh_relaxation, "program_stage", lambda *_: None)
    monkeypatch.setattr(mesh_relaxation, "recover_cam", lambda *_, **__: None)
    monkeypatch.setattr(
        mesh_relaxation, "row_violations", lambda *_: (broken if left else whole, None)
    )
    state: Any = State(0.7)  # of another mesh
    _, found = mesh_relaxation.solve_and_separate(state, 1)
    assert used == margins
    assert found is not None
    assert found.value == best
