"""Files of spatial cams: each in its place, as the library writes it, and refusals."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest

from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files import FORMATS, formats_of
from tests.service.conftest import Running
from tests.service.resources.test_spatial_cams import P4, WHERE
from tests.service.workers.test_trouble import is_problem

SMALL: dict[str, dict[str, Any]] = {
    "flanks.step": {"tolerance_um": 3.0, "flank": "1L"},
    "surfaces.json": {"points_per_degree": 0.2, "bore_mm": 37.5},
    **{name: {"points_per_degree": 0.5} for name in FORMATS if name.startswith("motion")},
    "cutter.csv": {"cutter_diameter_mm": 41.0, "flank": "2R", "points_per_degree": 0.2},
    "body.stl": {"points_per_degree": 0.1, "depths": 2, "bore_mm": 37.5},
    "body.step": {"form": "faceted", "points_per_degree": 0.1, "depths": 2, "bore_mm": 37.5},
}  # fmt: skip
FLANKS = {"points": 11, "depths": 3, "flank": "2R"}


@pytest.fixture(scope="module")
def answer(service: Running) -> dict[str, Any]:
    return service.client.post(WHERE, json=P4).json()  # type: ignore[no-any-return]


@pytest.mark.parametrize("name", formats_of("globoidal_indexer"))
def test_a_file_is_what_the_library_writes(
    client: httpx2.Client, answer: dict[str, Any], name: str
) -> None:
    exporter = FORMATS[name]
    question = SMALL.get(name, FLANKS)
    got = client.get(answer["links"][name], params=question)
    assert got.status_code == 200, got.text
    assert got.headers["content-type"] == exporter.media_type
    part = name.removesuffix(exporter.extension)
    assert f'filename="P4-{part}{exporter.extension}"' in got.headers["content-disposition"]
    made = exporter.content(SpatialDesign.model_validate(answer), exporter.options(**question))
    assert got.content == made.data
    reported = {key: got.headers[f"camwright-{key}"] for key in made.metadata}
    assert reported == dict(made.metadata)
    known = {"If-None-Match": got.headers["etag"]}
    assert client.get(answer["links"][name], params=question, headers=known).status_code == 304


def test_the_catalogue_has_them(client: httpx2.Client) -> None:
    entries = client.get("/v1/formats").json()["spatial"]
    assert [entry["name"] for entry in entries] == list(FORMATS)


def test_what_makes_no_sense_is_refused_at_its_field(
    client: httpx2.Client, answer: dict[str, Any]
) -> None:
    flanks, body = "flanks.csv", "body.stl"
    wrong = [(flanks, "flank", "8L"), (flanks, "points", 1), (body, "bore_mm", 190),
             (body, "colour", "red")]  # fmt: skip
    for file, name, value in wrong:
        refused = client.get(answer["links"][file], params={name: value})
        assert refused.status_code == 422
        reported = refused.json()["errors"][0]
        assert (reported.get("parameter") or reported["pointer"]).removeprefix("/") == name, (
            reported
        )
    is_problem(client.get(f"{WHERE}/{'0' * 32}/flanks.csv"), 404, "unknown-spatial-cam")
