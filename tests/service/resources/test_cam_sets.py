"""/v1/cam-sets: the same rules as for designs, and the files of a set; `camwright cam-set`."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import httpx2
import pytest
from typer.testing import CliRunner

from service import cli
from service.contract.examples import VARIANTS, examples
from synthesis import CamSet, CamSetSpec, DesignSpec
from synthesis.design.cam_set import set_id
from synthesis.errors.violations import describe_errors
from synthesis.exporters.bundle import BundleOptions, bundle
from synthesis.spec.cam_set import MAX_CAMS
from tests.exporters.test_bundle import STEEP
from tests.service.conftest import Running, settings_for, wait_until
from tests.service.contract.test_openapi import document
from tests.service.resources.test_designs import wait_for
from tests.service.specs import spec as design_spec
from tests.studies.cam_sets import INLET, PRESS, body

runner = CliRunner()
FREE = {  # a free law: tens of milliseconds
    "program": [
        {"kind": "rise", "angle_deg": 71.3, "lift_mm": 13.7},
        {"kind": "return", "angle_deg": 112.9, "lift_mm": 13.7},
        {"kind": "dwell", "angle_deg": 175.8},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 2.1},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30, "return_deg": 45},
        {"kind": "jerk", "max_mm_per_s3": 5e6},
    ],
    "tolerance": 0.01,
}
SLOW = {  # free laws of many segments: many seconds
    "program": [
        {"kind": kind, "angle_deg": 15.0, "lift_mm": 7.3}
        for _ in range(12) for kind in ("rise", "return")
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 9.1},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30, "return_deg": 45},
        {"kind": "profile_radius", "min_mm": 3.3},
        {"kind": "jerk", "max_mm_per_s3": 5e7},
    ],
    "tolerance": 1e-5,
}  # fmt: skip


def named(name: str, **changes: Any) -> dict[str, Any]:
    return body(name=name, **changes)


def post(client: httpx2.Client, question: dict[str, Any], **headers: str) -> httpx2.Response:
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    return client.post("/v1/cam-sets", json=question, headers=given)


def wrong(client: httpx2.Client, question: dict[str, Any]) -> list[dict[str, Any]]:
    answer = post(client, question)
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    errors: list[dict[str, Any]] = answer.json()["errors"]
    return errors


# --- ask, look, list, forget ---------------------------------------------------------------------


def test_a_set_comes_back_and_stays(client: httpx2.Client) -> None:
    question = named("first set")
    answer = post(client, question)
    assert answer.status_code == 200, answer.text
    found = CamSet.model_validate_json(answer.content)
    assert found.id == set_id(CamSetSpec.model_validate(question))
    assert found.status == "optimal"
    assert answer.headers["content-location"] == found.links["self"] == f"/v1/cam-sets/{found.id}"
    again = client.get(found.links["self"])
    assert (again.status_code, again.content) == (200, answer.content)
    assert post(client, question).content == answer.content
    known = {"If-None-Match": answer.headers["etag"]}
    assert client.get(found.links["self"], headers=known).status_code == 304


def test_the_same_question_said_otherwise(client: httpx2.Client) -> None:
    """What the shaft gives may be said once more, in any order of names."""
    question = named("said twice")
    first = post(client, question)
    for cam in question["cams"]:
        cam["spec"] = {"rotation": "ccw", "speed_rpm": 143.7} | cam["spec"]
    second = post(client, dict(reversed(question.items())))
    assert second.headers["content-location"] == first.headers["content-location"]
    assert second.content == first.content


def test_an_idempotency_key_replays_and_is_one_for_all(client: httpx2.Client) -> None:
    question = named("keyed set")
    first = post(client, question, Idempotency_Key="set-1")
    assert post(client, question, Idempotency_Key="set-1").content == first.content
    other = post(client, named("keyed set 2"), Idempotency_Key="set-1")
    assert other.json()["type"] == "/problems/idempotency-key-reused"
    headers = {"Idempotency-Key": "set-1"}
    design = client.post("/v1/designs", json=design_spec(), headers=headers)
    assert design.json()["type"] == "/problems/idempotency-key-reused"


def test_asynchronously(client: httpx2.Client) -> None:
    question = named("later", cams=[*[{"name": "free", "spec": FREE}] * 4, *body()["cams"]])
    answer = post(client, question, Prefer="respond-async")
    assert answer.status_code == 202, answer.text
    assert answer.headers["preference-applied"] == "respond-async"
    where = answer.headers["location"]
    assert where == f"/v1/cam-sets/{answer.json()['id']}"
    early = client.get(f"{where}/bundle.zip")
    assert early.status_code == 409
    assert early.json()["detail"].startswith("Cam set ")
    found = wait_for(client, where)
    assert found.status_code == 200
    assert [cam["name"] for cam in found.json()["cams"]] == [
        *(f"free ({i})" for i in range(1, 5)),
        "inlet",
        "press",
    ]
    assert client.get(f"{where}/bundle.zip").status_code == 200


def test_a_set_under_way_is_dismissed(client: httpx2.Client) -> None:
    question = named("never", cams=[{"name": f"slow {i}", "spec": SLOW} for i in range(40)])
    where = post(client, question, Prefer="respond-async").headers["location"]
    wait_until(client, running=1)
    assert client.delete(where).status_code == 204
    assert client.get(where).status_code == 404
    assert client.delete(where).json()["type"] == "/problems/unknown-cam-set"


def test_what_was_accepted_outlives_the_process(tmp_path: Path) -> None:
    settings = settings_for(tmp_path, workers=1)
    question = named("kept", cams=[{"name": f"free {i}", "spec": FREE} for i in range(2)])
    with Running(settings, real=False) as service:
        where = post(service.client, question, Prefer="respond-async").headers["location"]
    with Running(settings, real=False) as service:
        assert wait_for(service.client, where).json()["name"] == "kept"


def test_where_time_ends_the_problem_is_told(client: httpx2.Client) -> None:
    cams = [{"name": f"slow {i}", "spec": SLOW} for i in range(20)]
    answer = post(client, named("in no time", cams=cams, time_budget_s=0.05))
    assert answer.status_code == 504, answer.text
    assert answer.json()["type"] == "/problems/time-budget"


def test_the_list(client: httpx2.Client) -> None:
    names = [f"listed set {i}" for i in range(3)]
    made = [post(client, named(name)).json()["id"] for name in names]
    page = client.get("/v1/cam-sets", params={"limit": 2}).json()
    rest = client.get("/v1/cam-sets", params={"limit": 1, "cursor": page["next"]}).json()
    lines = page["items"] + rest["items"]
    assert [line["id"] for line in lines] == made[::-1]
    assert lines[0]["status"] == "optimal"
    assert (lines[0]["cams"], lines[0]["solved"]) == (2, 2)
    assert set(lines[0]["links"]) == {"self", "timing.svg", "bundle.zip"}
    assert names[0] not in [line["name"] for line in client.get("/v1/designs").json()["items"]]


def test_designs_and_sets_do_not_answer_for_each_other(client: httpx2.Client) -> None:
    name = post(client, named("not a design")).json()["id"]
    assert client.get(f"/v1/designs/{name}").status_code == 404
    assert client.get(f"/v1/cam-sets/{name}").status_code == 200


# --- files ---------------------------------------------------------------------------------------


def test_the_archive(client: httpx2.Client) -> None:
    found = CamSet.model_validate_json(post(client, named("with files")).content)
    answer = client.get(found.links["bundle.zip"])
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/zip"
    assert answer.headers["content-disposition"] == ('attachment; filename="with-files-bundle.zip"')
    assert answer.content == bundle(found, BundleOptions())
    assert client.get(found.links["bundle.zip"]).content == answer.content
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        for each in manifest["files"]:
            assert hashlib.sha256(archive.read(each["name"])).hexdigest() == each["sha256"]
    known = {"If-None-Match": answer.headers["etag"]}
    assert client.get(found.links["bundle.zip"], headers=known).status_code == 304


def test_options_of_the_archive(client: httpx2.Client) -> None:
    path = post(client, named("chosen files")).json()["links"]["bundle.zip"]
    query = "profile=txt&profile=json&motion=svg&points_per_degree=1&curve=pitch"
    plain, chosen = client.get(path), client.get(f"{path}?{query}")
    assert chosen.headers["etag"] != plain.headers["etag"]
    with zipfile.ZipFile(io.BytesIO(chosen.content)) as archive:
        inside = [name for name in archive.namelist() if name.startswith("01-")]
        assert inside == [
            f"01-inlet/{name}"
            for name in ("design.json", "pitch.json", "shaft-pitch.json", "pitch.txt",
                         "shaft-pitch.txt", "motion.svg")
        ]  # fmt: skip
        assert json.loads(archive.read("01-inlet/pitch.json"))["curve"] == "pitch"
        assert archive.read("01-inlet/pitch.txt").count(b"\n") < 400


@pytest.mark.parametrize(
    ("query", "parameter", "words"),
    [
        ("profile=dwg", "profile", "must be one of"),
        ("motion=csv&motion=xls", "motion", "must be one of"),
        ("points_per_degree=11", "points_per_degree", "at most 10"),
        ("tolerance_um=0.01", "tolerance_um", "at least 0.1"),
        ("curve=inner", "curve", "profile, pitch"),
        ("shape=round", "shape", "not a parameter"),
    ],
)
def test_options_that_make_no_sense(
    client: httpx2.Client, query: str, parameter: str, words: str
) -> None:
    answer = client.get(f"/v1/cam-sets/0000/bundle.zip?{query}")
    assert answer.status_code == 422, answer.text
    (error,) = answer.json()["errors"]
    assert error["parameter"] == parameter
    assert words in f"{error['rule']} {error['remedy']}"


def test_the_diagram(client: httpx2.Client) -> None:
    path = post(client, named("drawn")).json()["links"]["timing.svg"]
    answer = client.get(path)
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "image/svg+xml"
    assert answer.headers["content-security-policy"].startswith("default-src 'none'")
    assert answer.headers["content-disposition"] == 'inline; filename="drawn-timing.svg"'
    known = {"If-None-Match": answer.headers["etag"]}
    assert client.get(path, headers=known).status_code == 304


def test_where_nothing_fits_there_are_no_files(client: httpx2.Client) -> None:
    found = post(client, named("steep", cams=[{"spec": STEEP}])).json()
    assert found["status"] == "infeasible"
    assert list(found["links"]) == ["self"]
    for name in ("timing.svg", "bundle.zip"):
        answer = client.get(f"{found['links']['self']}/{name}")
        assert answer.status_code == 409
        assert answer.json()["type"] == "/problems/nothing-fits"
    line = client.get("/v1/cam-sets", params={"status": "infeasible"}).json()["items"][0]
    assert (line["cams"], line["solved"], list(line["links"])) == (1, 0, ["self"])


# --- what makes no sense -------------------------------------------------------------------------


def with_second(**changes: Any) -> dict[str, Any]:
    """The set with its second cam's spec changed."""
    question = named("wrong")
    question["cams"][1] = question["cams"][1] | {"spec": PRESS | changes}
    return question


@pytest.mark.parametrize(
    ("question", "pointer", "value", "words"),
    [
        (with_second(speed_rpm=60), "/cams/1/spec/speed_rpm", 60.0, "143.7 of the shaft"),
        (with_second(rotation="cw"), "/cams/1/spec/rotation", "cw", "ccw of the shaft"),
        (with_second(program=PRESS["program"][:3]), "/cams/1/spec/program", 255.0, "not 360°"),
        (
            with_second(follower=PRESS["follower"] | {"offset_mm": 99}),
            "/cams/1/spec/follower/offset_mm", 99.0, "would miss",
        ),
        (with_second(base_radius=3), "/cams/1/spec/base_radius", 3, "base_radius_mm"),
        (
            with_second(limits=[{"kind": "outer_radius"}]),
            "/cams/1/spec/limits/0/max_mm", None, "is required",
        ),
        (named("wrong", cams=[{"phase": 3, "spec": INLET}]), "/cams/0/phase", 3, "phase_deg"),
        (named("wrong", cams=[{"phase_deg": 400, "spec": INLET}]), "/cams/0/phase_deg", 400,
         "at most 360"),
        (named("wrong", cams=[{"name": "x"}]), "/cams/0/spec", None, "is required"),
        (named("wrong", cams=[]), "/cams", [], "at least 1"),
        (named("wrong", cams=[{"spec": INLET}] * (MAX_CAMS + 1)), "/cams", ..., "at most 50"),
        (named("wrong", speed_rpm=0), "/speed_rpm", 0, "positive"),
        (named("wrong", speed_rpm="fast"), "/speed_rpm", "fast", "number"),
        (named("wrong", axle=1), "/axle", 1, "cams"),
        (named("wrong", cams=[3]), "/cams/0", 3, "must be"),
        (named("wrong", cams={}), "/cams", {}, "must be a list"),
    ],
)  # fmt: skip
def test_sets_that_make_no_sense(
    client: httpx2.Client, question: dict[str, Any], pointer: str, value: Any, words: str
) -> None:
    errors = wrong(client, question)
    assert [error["pointer"] for error in errors] == [pointer], errors
    if value is not ...:
        assert errors[0]["value"] == value
    assert words in f"{errors[0]['rule']} {errors[0]['remedy']}", errors


def test_rules_over_several_fields_are_placed_in_the_spec_that_broke_them() -> None:
    """Wherever in it they were found."""
    error = {"type": "program_angles", "input": {}, "msg": "Wrong. Mend it.", "ctx": {}}
    for inside in ((), ("program",), ("program", 0)):
        places = [
            describe_errors([error | {"loc": (*spec, *inside)}], question, model)[0][0]["pointer"]
            for spec, question, model in (
                ((), INLET, DesignSpec),
                (("cams", 1, "spec"), body(), CamSetSpec),
            )
        ]
        assert places == ["/program", "/cams/1/spec/program"]


def test_the_server_says_how_many_cams(client: httpx2.Client) -> None:
    assert client.get("/v1/limits").json()["server"]["max_cams"] == MAX_CAMS


# --- documentation and the command ---------------------------------------------------------------


@pytest.mark.parametrize("name", examples("cam-sets"))
def test_worked_examples(client: httpx2.Client, name: str) -> None:
    example = examples("cam-sets")[name]
    assert set(example) == {"summary", "description", "value"}
    question = document()["paths"]["/v1/cam-sets"]["post"]["requestBody"]
    shown = question["content"]["application/json"]
    assert name in VARIANTS or shown["examples"][name] == example
    assert shown["schema"] == {"$ref": "#/components/schemas/CamSetSpec"}
    answer = post(client, example["value"])
    assert answer.status_code == 200, answer.text
    assert answer.json()["status"] in ("optimal", "feasible")
    assert client.get(answer.json()["links"]["bundle.zip"]).status_code == 200


def test_the_command_writes_the_archive_s_files(tmp_path: Path) -> None:
    path = tmp_path / "set.json"
    path.write_text(json.dumps(named("by command")), encoding="utf-8")
    done = runner.invoke(cli.app, ["cam-set", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    out = tmp_path / "out"
    found = CamSet.model_validate_json((out / "cam-set.json").read_bytes())
    assert found.status == "optimal"
    manifest = json.loads((out / "manifest.json").read_bytes())
    for each in manifest["files"]:
        content = (out / each["name"]).read_bytes()
        assert hashlib.sha256(content).hexdigest() == each["sha256"]
    assert (out / "02-press" / "shaft-profile.txt").exists()
    for words in ("optimal", "inlet", "press", "phase -143.2°", "keyway at"):
        assert words in done.output, done.output


def test_the_command_says_that_nothing_fits(tmp_path: Path) -> None:
    path = tmp_path / "set.json"
    cams = [*body()["cams"], {"name": "steep", "spec": STEEP}]
    path.write_text(json.dumps(named("by command", cams=cams)), encoding="utf-8")
    done = runner.invoke(cli.app, ["cam-set", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 3, done.output
    assert "steep: infeasible" in done.output
    assert (tmp_path / "out" / "manifest.json").exists()


def test_the_command_tells_what_is_wrong(tmp_path: Path) -> None:
    path = tmp_path / "set.json"
    path.write_text(json.dumps(with_second(speed_rpm=60)), encoding="utf-8")
    done = runner.invoke(cli.app, ["cam-set", str(path)])
    assert done.exit_code == 2
    assert "/cams/1/spec/speed_rpm = 60" in done.output
