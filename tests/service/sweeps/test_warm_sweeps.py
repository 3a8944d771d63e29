"""Sweeps whose designs begin where the item before has ended: chains, and what breaks them."""

from __future__ import annotations

import time
import zlib
from itertools import pairwise
from pathlib import Path
from typing import Any

import httpx2
import pytest

from benchmarks.proof import SCENES
from service.sweeps.chunks import CHAIN, Chunks
from service.sweeps.tasks import ItemAnswer, solve_items
from service.workers.tasks import solve_design
from synthesis.design.design import Design
from synthesis.design.identity import design_id
from synthesis.pipeline.synthesise import Neighbour, synthesise
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps import SweepSpec
from tests.service.conftest import Running
from tests.service.fake_core import Gate
from tests.service.specs import spec
from tests.service.sweeps.test_sweeps import items_at, over, posted


def speeds(name: str, count: int) -> dict[str, Any]:
    axis = {"kind": "range", "pointer": "/speed_rpm", "start": 10, "stop": 20, "count": count}
    return {"name": "warm", "base": spec(name), "axes": [axis], "warm_start": True}


def chained(client: httpx2.Client, where: str, count: int) -> None:
    """Every item once, each begun at the one before, but for the first of a chain."""
    items = sorted(items_at(client, where), key=lambda item: item["number"])
    assert [item["number"] for item in items] == list(range(count))
    designs = [client.get(item["links"]["design"]).json() for item in items]
    for number, design in enumerate(designs):
        before = designs[number - 1]["id"] if number % CHAIN else None
        assert design["started_from"] == before
        assert items[number]["links"]["design"].endswith(design["id"])
    assert len({design["id"] for design in designs}) == count


def test_items_begin_where_the_one_before_ended(client: httpx2.Client) -> None:
    where = posted(client, speeds("x", 21))
    assert over(client, where)["counts"]["optimal"] == 21
    chained(client, where, 21)


def test_a_chain_longer_than_a_time_slice_stays_one(client: httpx2.Client) -> None:
    where = posted(client, speeds("sleep 0.3", 6))
    assert over(client, where)["counts"]["optimal"] == 6
    chained(client, where, 6)


def test_a_chain_that_was_stopped_goes_on_as_one(service: Running, tmp_path: Path) -> None:
    client, gate = service.client, Gate(tmp_path / "gate")
    (name,) = gate.names(1)
    body = speeds(name, 7)
    where = posted(client, body)
    gate.let(3)
    while any(tmp_path.glob("gate/place *")):
        time.sleep(0.01)
    assert 2 <= client.delete(where).json()["counts"]["done"] <= 3
    gate.open()
    assert posted(client, body) == where
    assert over(client, where)["counts"]["optimal"] == 7
    chained(client, where, 7)


def test_chains_are_the_same_ones_whatever_is_done() -> None:
    """Items 9 and 12 are done, 10 is suspected: it is sent alone, the others with these."""
    chunks = Chunks(21, [9, 12], 2, {10: 1}, CHAIN)
    assert chunks.left == 19
    assert chunks.take() == [10]
    assert chunks.take() == [*range(8)]
    second = chunks.take()
    assert second == [8, 9, 11, 12, 13, 14, 15]
    assert chunks.unfinished(second) == [8, 11, 13, 14, 15]
    assert chunks.finish(8)
    assert not chunks.finish(9)
    chunks.put_back([14, 15])
    assert chunks.left == 5 + 2
    assert [chunks.take(), chunks.take(), chunks.take()] == [[14, 15], [*range(16, 21)], []]
    assert chunks.left == 0


SCENE = SCENES[0]
AXIS = {"kind": "list", "pointer": "/limits/0/rise_deg", "values": [30.0, 29.7, 29.4]}


@pytest.fixture(scope="module")
def warm() -> list[Design]:
    """Three neighbours where curvature decides, by the real core."""
    base = SCENE.spec().model_dump(mode="json")
    sweep = SweepSpec.model_validate({"base": base, "axes": [AXIS], "warm_start": True})
    wanted = [(number, sweep.item_values(number)) for number in range(sweep.size)]
    body, found, near = sweep.model_dump_json().encode(), list[ItemAnswer](), None
    while len(found) < sweep.size:  # a busy machine's time slices end between them
        more, near = solve_items(body, wanted[len(found) :], 60.0, solve_design, near)
        found += more
        assert near is not None
    return [Design.model_validate_json(zlib.decompress(answer.design or b"")) for answer in found]


def test_the_first_of_a_chain_is_that_of_its_spec_alone(warm: list[Design]) -> None:
    alone = synthesise(warm[0].spec)
    assert warm[0].started_from is None
    assert warm[0].id == alone.id == design_id(warm[0].spec)
    assert warm[0].motion == alone.motion


def test_the_others_are_proven_and_as_good_as_alone(warm: list[Design]) -> None:
    for before, design in pairwise(warm):
        assert design.started_from == before.id
        assert design.id != design_id(design.spec)
        assert any("neighbour" in stage.stage for stage in design.report.stages)
        alone = synthesise(design.spec).certificate
        proof = design.certificate
        assert proof.certified
        assert proof.lower_bound == alone.lower_bound
        assert proof.value == pytest.approx(alone.value, rel=2e-3)


def test_a_start_of_another_form_is_left_aside(warm: list[Design]) -> None:
    """Laws on other segments: nothing of the neighbour's serves, and the answer is the spec's."""
    neighbours: list[Neighbour] = []
    synthesise(warm[0].spec, neighbours=neighbours)
    body = warm[0].spec.model_dump(mode="json")
    body["program"][0]["law"] = {"kind": "polynomial_7"}
    other = DesignSpec.model_validate(body)
    found = synthesise(other, neighbours=neighbours)
    assert found.started_from is None
    assert found.motion == synthesise(other).motion


def test_given_laws_have_their_own_displacements_from_a_neighbour() -> None:
    """The return is given, and 5 % longer at the neighbour: its laws begin another motion here."""
    body = SCENE.spec().model_dump(mode="json")
    body["program"][2]["law"] = {"kind": "cycloidal"}
    question = DesignSpec.model_validate(body)
    for segment in (body["program"][0], body["program"][2]):
        segment["lift_mm"] *= 1.05
    neighbours: list[Neighbour] = []
    synthesise(DesignSpec.model_validate(body), neighbours=neighbours)
    near = neighbours[-1]
    found = synthesise(question, neighbours=neighbours)
    assert found.started_from == near.id
    assert found.certificate.value == pytest.approx(
        synthesise(question).certificate.value, rel=5e-4
    )
