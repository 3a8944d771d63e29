"""The last digits of a bound: knots on the switches of laws that have some."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from synthesis.optimise.refinement import mesh


def test_laws_without_a_switch_get_no_mesh_of_their_switches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A law that time has ended for may be as smooth as its mesh: nothing tells where knots go."""
    state: Any = SimpleNamespace(
        relaxation=object(), relaxed=object(), problem=None, time_left=1.0, tolerance=1e-9,
        is_close=lambda cam: False,
    )  # fmt: skip
    monkeypatch.setattr(mesh, "grids_on_switches", lambda *_: ())
    monkeypatch.setattr(mesh, "_with_best_multipliers", lambda state: ("raised", state))

    def solve_once(state: Any, number: int) -> Any:
        pytest.fail("a program without a mesh")

    assert mesh._improve_multipliers(state, solve_once) == ("raised", state)
