"""What every limit and every objective of the catalogue has to keep; a new one needs a scene."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.catalogue.limits import LIMITS
from synthesis.catalogue.objectives import OBJECTIVES
from tests.catalogue import scenes

LIMIT_KINDS = [limit.model_fields["kind"].default for limit in LIMITS]
OBJECTIVE_KINDS = [objective.model_fields["kind"].default for objective in OBJECTIVES]
TABLES = {"LIMITS": scenes.LIMITS, "OBJECTIVES": scenes.OBJECTIVES}
REACHED = 2e-3  # relative: how near to its bound an extreme of a limit that binds is
LOOSEST = 0.05  # gap of an objective in its scene


def question(table: str, kind: str) -> DesignSpec:
    """The scene of a kind."""
    scene = TABLES[table].get(kind)
    assert scene is not None, f"{kind!r} has no scene: add it to {table} in {scenes.__file__}"
    return DesignSpec.model_validate(scene)


@lru_cache(maxsize=32)
def solved(table: str, kind: str) -> Design:
    """The certified design of a kind's scene."""
    design = synthesise(question(table, kind))
    assert design.certificate.certified, design.conflict
    return design


@pytest.mark.parametrize("kind", LIMIT_KINDS)
def test_a_limit_is_reached_in_its_scene(kind: str) -> None:
    """Rows, cuts and claims speak of one quantity: the optimum lies on the limit, not before it."""
    used = {
        extreme.limit: abs(extreme.margin) / max(abs(extreme.bound or 0.0), 1e-12)
        for extreme in solved("LIMITS", kind).extremes
        if kind in extreme.field.split("/") and extreme.margin is not None
    }
    assert used, f"the certificate measures nothing for {kind}"
    assert min(used.values()) <= REACHED, f"{kind} is not reached: {used}"


@pytest.mark.parametrize("kind", LIMIT_KINDS)
def test_a_limit_states_bounds_that_name_their_field(kind: str) -> None:
    """A claim with no bound, or of a field of another limit, would be a limit that nobody keeps."""
    spec = question("LIMITS", kind)
    (limit,) = (one for one in spec.limits if one.kind == kind)
    machine = replace(spec.machine(), follower=solved("LIMITS", kind).completed_spec.follower)
    claims = limit.claims(spec.placed_segments(), machine)
    assert claims
    for claim in claims:
        prefix, _, field = claim.field.partition("/")
        assert prefix == kind
        assert field in type(limit).model_fields
        assert claim.lower is not None or claim.upper is not None
        assert claim.segments


@pytest.mark.parametrize("kind", OBJECTIVE_KINDS)
def test_an_objective_has_a_near_bound_in_its_scene(kind: str) -> None:
    """The dual bound knows what the objective is: a value proven loose would mean it does not."""
    proof = solved("OBJECTIVES", kind).certificate
    assert proof.gap is not None, f"{kind} has no bound"
    assert -1e-9 <= proof.gap <= LOOSEST, f"{kind}: {proof.gap:.1%} lies between value and bound"
    assert proof.bound_valid_for.startswith("all motion laws"), f"{kind}: {proof.bound_valid_for}"


@pytest.mark.parametrize("kind", OBJECTIVE_KINDS)
def test_an_objective_goes_to_the_wire_and_back(kind: str) -> None:
    spec = question("OBJECTIVES", kind)
    machine, (objective,) = spec.machine(), spec.objectives()
    for value in (0.3, 17.9):
        there = objective.to_wire(value, machine)
        assert objective.from_wire(there, machine) == pytest.approx(value, rel=1e-12)
    assert objective.to_wire(0.4, machine) > objective.to_wire(0.3, machine)
    assert list(solved("OBJECTIVES", kind).objectives) == [objective.name_on_wire(machine)]
