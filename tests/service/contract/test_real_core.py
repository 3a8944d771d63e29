"""The service with the real core: every worked example, every file, and what the way costs."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import httpx2
import pytest

from service.contract.examples import SELF_CHECK, examples
from synthesis.pipeline.proof_file.checker import checker_path
from tests.service.conftest import Running, wait_until, wait_until_idle
from tests.service.sweeps.test_sweeps import over


@pytest.fixture(scope="module")
def client(real_service: Running) -> httpx2.Client:
    return real_service.client


def post(client: httpx2.Client, body: dict[str, Any]) -> httpx2.Response:
    answer = client.post("/v1/designs", json=body)
    assert answer.status_code == 200, answer.text
    return answer


# the dearest of them, which tests/validation solves: as dear as all others
@pytest.mark.parametrize("name", [name for name in examples() if name != "spot-weld"])
def test_worked_examples(client: httpx2.Client, name: str) -> None:
    value = examples()[name]["value"]
    design = post(client, value).json()
    if name.startswith("infeasible"):
        assert design["status"] == "infeasible"
        assert design["conflict"]["relaxations"]
        assert list(design["links"]) == ["self", "report.html", "proof.json"]
        return
    assert design["certificate"]["certified"]
    assert all(extreme["holds"] for extreme in design["extremes"])
    if design["status"] == "optimal":
        listed = value.get("objective") or {}
        first = listed[0] if isinstance(listed, list) else listed
        share = first.get("allowance", 0.0)  # of the least value, which the gap is not counted in
        allowed = max(value.get("tolerance", 1e-3), share / (1.0 + share))
        assert design["certificate"]["gap"] <= allowed


def test_programs_that_would_spoil_a_workpiece(client: httpx2.Client) -> None:
    where = f"/v1/designs/{post(client, examples()['flat-face']['value']).json()['id']}"
    for query, parameter in (
        ("profile.grinding.nc", "curve"),
        ("profile.nc?curve=pitch", "curve"),
        ("profile.nc?safe_z_mm=-9&z_mm=-4", "safe_z_mm"),
    ):
        answer = client.get(f"{where}/{query}")
        assert answer.status_code == 422, query
        (found,) = answer.json()["errors"]
        assert found["parameter"] == parameter
        assert found["rule"]
        assert found["remedy"]
    answer = client.get(f"{where}/profile.grinding.nc?curve=cutter&cutter_diameter_mm=40")
    assert answer.status_code == 200


def test_a_sweep_is_stopped_in_the_middle_of_its_solves(client: httpx2.Client) -> None:
    """Both workers sit in a proof of several seconds; nothing of it is stored afterwards."""
    base = examples()["undercut-limit"]["value"]
    base = {**base, "proof": "thorough", "tolerance": 1e-6, "time_budget_s": 100.0}
    axis = {"kind": "range", "pointer": "/speed_rpm", "start": 91.3, "stop": 97.1, "count": 9}
    answer = client.post("/v1/sweeps", json={"base": base, "axes": [axis]})
    where = answer.headers["location"]
    wait_until(client, running=2)
    stopped = client.delete(where).json()
    assert stopped["state"] == "dismissed"
    assert stopped["counts"]["done"] < 9
    wait_until_idle(client)
    assert client.get(where).json() == stopped


def test_an_infeasible_design_has_no_files(client: httpx2.Client) -> None:
    design = post(client, examples()["infeasible-on-purpose"]["value"]).json()
    answer = client.get(f"/v1/designs/{design['id']}/profile.csv")
    assert answer.status_code == 409
    assert answer.json()["type"] == "/problems/nothing-fits"


def test_a_given_cam_that_breaks_its_limits_is_drawn_and_named_so(client: httpx2.Client) -> None:
    value = examples()["fixed-laws"]["value"] | {"base_radius_mm": 41.3}
    value = value | {"follower": value["follower"] | {"offset_mm": 11.7}}
    design = post(client, value).json()
    assert design["status"] == "infeasible"
    assert any(not extreme["holds"] for extreme in design["extremes"])
    answer = client.get(design["links"]["profile.csv"])
    assert answer.status_code == 200
    assert "-not-certified-profile.csv" in answer.headers["content-disposition"]


@pytest.fixture(scope="module")
def links(client: httpx2.Client) -> dict[str, str]:
    found: dict[str, str] = post(client, examples()[SELF_CHECK]["value"]).json()["links"]
    return found


def test_what_each_limit_costs(client: httpx2.Client, links: dict[str, str]) -> None:
    answer = client.get(f"{links['self']}/sensitivities")
    assert answer.status_code == 200, answer.text
    dearest = answer.json()["sensitivities"][0]
    assert dearest["per_unit"] < 0.0
    assert "smaller" in dearest["sentence"]
    known = {"If-None-Match": answer.headers["etag"]}
    assert client.get(f"{links['self']}/sensitivities", headers=known).status_code == 304
    nothing = post(client, examples()["infeasible-on-purpose"]["value"]).json()
    reported = client.get(f"{nothing['links']['self']}/sensitivities").json()
    assert reported["sensitivities"] == []


def test_every_file(client: httpx2.Client, links: dict[str, str]) -> None:
    formats = client.get("/v1/formats").json()
    described = {
        f"{part}.{each['name']}": each
        for part in ("profile", "motion", "solid")
        for each in formats[part]
    } | {each["name"]: each for each in formats["pictures"]}
    assert set(links) == {"self", "proof.json", *described}
    for name, each in described.items():
        answer = client.get(links[name])
        assert answer.status_code == 200
        assert answer.headers["content-type"] == each["media_type"]
        how, _, file_name = answer.headers["content-disposition"].partition("; filename=")
        shown = each["extension"] in (".svg", ".html", ".png")
        assert how == ("inline" if shown else "attachment")
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'")
        assert ("sandbox" in policy) == (each["extension"] == ".html")
        assert file_name.strip('"') == f"example-13-6-{name}"
        known = {"If-None-Match": answer.headers["etag"]}
        assert client.get(links[name], headers=known).status_code == 304


def test_themes_of_pictures(client: httpx2.Client, links: dict[str, str]) -> None:
    for name in ("profile.svg", "motion.svg", "contact.svg", "animation.html"):
        dark, light = (client.get(f"{links[name]}?theme={theme}") for theme in ("dark", "print"))
        assert dark.headers["etag"] != light.headers["etag"]
        assert "#15191e" in dark.text
        assert "#15191e" not in light.text
    wrong = client.get(f"{links['contact.svg']}?theme=pink")
    assert (wrong.status_code, wrong.json()["errors"][0]["parameter"]) == (422, "theme")


def test_reports(client: httpx2.Client, links: dict[str, str]) -> None:
    plain = client.get(links["report.html"])
    costs = client.get(f"{links['report.html']}?sensitivities=true")
    assert "What each limit costs" in costs.text
    assert "What each limit costs" not in plain.text
    assert "<a href=proof.json>" in plain.text
    assert plain.headers["etag"] != costs.headers["etag"]
    csv = client.get(links["profile.csv"]).content
    assert hashlib.sha256(csv).hexdigest() in plain.text
    nothing = post(client, examples()["infeasible-on-purpose"]["value"]).json()
    assert set(nothing["links"]) == {"self", "report.html", "proof.json"}
    reported = client.get(nothing["links"]["report.html"])
    assert reported.status_code == 200
    assert "Why nothing fits" in reported.text
    drawing = client.get(f"{nothing['links']['self']}/animation.svg")
    assert (drawing.status_code, drawing.json()["type"]) == (409, "/problems/nothing-fits")


def test_options_choose_the_points(client: httpx2.Client, links: dict[str, str]) -> None:
    path = links["profile.csv"]

    def lines(query: str) -> int:
        return len(client.get(f"{path}?{query}").text.splitlines()) - 1

    assert lines("points_per_degree=1") < lines("points_per_degree=4") == lines("") + 0
    assert lines("tolerance_um=100") < lines("tolerance_um=1")
    pitch, profile = (client.get(f"{path}?curve={curve}") for curve in ("pitch", "profile"))
    assert pitch.headers["etag"] != profile.headers["etag"]
    assert pitch.text != profile.text
    missing = client.get(f"{path}?curve=counter")
    assert (missing.status_code, missing.json()["type"]) == (422, "/problems/invalid-parameter")
    (reported,) = missing.json()["errors"]
    assert (reported["parameter"], reported["value"]) == ("curve", "counter")
    assert "pitch" in reported["rule"]


def test_point_files_tell_what_their_readers_make_of_them(
    client: httpx2.Client, links: dict[str, str]
) -> None:
    answer = client.get(f"{links['profile.sldcrv']}?points=180&decimals=4")
    block = client.get(f"{links['profile.fidelity.json']}?points=180&decimals=4").json()
    reported = dict(each.split(": ") for each in answer.headers["camwright-fidelity"].split("; "))
    assert list(reported) == [each["reader"] for each in block["readers"]]
    for each in block["readers"]:
        assert reported[each["reader"]].startswith(f"form {each['form_um']:.3g} um, acceleration ")
    table = client.get(f"{links['profile.csv']}?points=180").headers["camwright-fidelity"]
    (periodic,) = (each for each in block["readers"] if each["reader"] == "periodic")
    unrounded = float(re.findall(r"periodic: form [^ ]+ um, acceleration ([^ ]+) %", table)[0])
    assert 0.0 < unrounded < 100.0 * periodic["acceleration_part"]  # 4 decimals cost something
    drive = client.get(f"{links['motion.cam.csv']}?points=90").headers["camwright-fidelity"]
    assert drive.startswith("linear: displacement ")
    assert "quintic: displacement " in drive
    close = client.get(f"{links['profile.sldcrv']}?points_per_degree=100")
    assert (close.status_code, close.json()["type"]) == (422, "/problems/invalid-parameter")
    assert "0.01 mm" in close.json()["detail"]


def test_exact_curves_tell_how_true_they_are(client: httpx2.Client, links: dict[str, str]) -> None:
    answer = client.get(f"{links['profile.nurbs.json']}?tolerance_um=0.01&curve=pitch")
    assert answer.json()["error_mm"] <= 1e-5
    reported = answer.headers["camwright-curve-error-mm"]
    assert float(reported) == pytest.approx(answer.json()["error_mm"], rel=5e-3)
    count = answer.headers["camwright-curve-control-points"]
    assert int(count) == len(answer.json()["control_points_mm"])
    for wrong, parameter in (
        ("tolerance_um=-1", "tolerance_um"),
        ("tolerance_um=1e-9", "tolerance_um"),
        ("curve=cutter", "cutter_diameter_mm"),
        ("curve=cutter&cutter_diameter_mm=1e5", "cutter_diameter_mm"),
        ("points_per_degree=4", "points_per_degree"),
    ):
        refused = client.get(f"{links['profile.step']}?{wrong}")
        assert (refused.status_code, refused.json()["type"]) == (422, "/problems/invalid-parameter")
        (violation,) = refused.json()["errors"]
        assert violation["parameter"] == parameter
        assert violation["remedy"]


def test_a_worker_makes_the_solid(client: httpx2.Client, links: dict[str, str]) -> None:
    answer = client.get(f"{links['solid.step']}?thickness_mm=8&bore_mm=14&keyway=true")
    assert answer.status_code == 200, answer.text
    assert float(answer.headers["camwright-volume-mm3"]) > 1e4
    refused = client.get(f"{links['solid.step']}?bore_mm=1000")
    assert (refused.status_code, refused.json()["type"]) == (422, "/problems/invalid-parameter")
    (violation,) = refused.json()["errors"]
    assert violation["parameter"] == "bore_mm"
    assert "smaller bore" in violation["remedy"]


def test_the_process_that_answers_holds_no_solver_and_no_kernel(real_service: Running) -> None:
    """In a process of its own, as this one may hold anything."""
    import subprocess

    heavy = ("cvxpy", "casadi", "OCP", "ezdxf")
    code = f"import sys, service.app; print([m for m in {heavy} if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_a_design_is_confirmed_to_25_digits(client: httpx2.Client) -> None:
    design = post(client, examples()["fixed-laws"]["value"]).json()
    path = f"/v1/designs/{design['id']}/confirmation"
    answer = client.get(path)
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert (found["verdict"], found["id"]) == ("confirmed", design["id"])
    assert [line["limit"] for line in found["lines"]] == [e["limit"] for e in design["extremes"]]
    known = {"if-none-match": answer.headers["etag"]}
    assert client.get(path, headers=known).status_code == 304
    none = post(client, examples()["infeasible-on-purpose"]["value"]).json()
    refused = client.get(f"/v1/designs/{none['id']}/confirmation")
    assert (refused.status_code, refused.json()["type"]) == (409, "/problems/nothing-fits")


def test_the_proofs_of_a_sweep_are_one_archive_that_the_checker_reads(
    client: httpx2.Client, tmp_path: Path
) -> None:
    base = examples()["flat-face"]["value"]
    caps = [base["limits"][2]["max_mm_per_s3"], 1e5]  # the latter is soon explained
    axis = {"kind": "list", "pointer": "/limits/2/max_mm_per_s3", "values": caps}
    where = client.post("/v1/sweeps", json={"base": base, "axes": [axis]}).headers["location"]
    assert over(client, where)["state"] == "successful"
    answer = client.get(f"{where}/proofs.zip", params={"item": [1, 0, 1]})
    assert answer.status_code == 200, answer.text
    (tmp_path / "proofs.zip").write_bytes(answer.content)
    command = [sys.executable, "-I", "-S", str(checker_path()), "proofs.zip"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
    assert found.stdout.splitlines()[0] == "proofs.zip/item-0.proof.json"
    assert "no cam of this question has a base_radius below" in found.stdout
    assert "infeasible: no law and no size keep these limits together" in found.stdout
    known = {"if-none-match": answer.headers["etag"]}
    again = client.get(f"{where}/proofs.zip", params={"item": [0, 1]}, headers=known)
    assert again.status_code == 304
    assert client.get(f"{where}/proofs.zip", params={"item": 7}).status_code == 404
    assert client.get(f"{where}/proofs.zip").status_code == 422


def test_a_design_has_a_proof_file_with_or_without_a_cam(client: httpx2.Client) -> None:
    for name, places in (("flat-face", 8), ("infeasible-on-purpose", 1)):
        design = post(client, examples()[name]["value"]).json()
        path = f"/v1/designs/{design['id']}/proof.json"
        answer = client.get(path)
        assert answer.status_code == 200, answer.text
        found = answer.json()
        assert (found["format"], found["id"]) == ("camwright-proof", design["id"])
        assert [claim["proven"] for claim in found["claims"]] == [True] * places
        known = {"if-none-match": answer.headers["etag"]}
        assert client.get(path, headers=known).status_code == 304
        assert client.get(path, headers={"prefer": "respond-async"}).content == answer.content


def test_a_proof_that_takes_work_can_be_asked_for_again(client: httpx2.Client) -> None:
    spec = {**examples()["flat-face"]["value"], "name": "proven later"}
    path = f"{post(client, spec).json()['links']['self']}/proof.json"
    later = {"prefer": "respond-async"}
    first = client.get(path, headers=later)
    assert (first.status_code, first.headers["location"]) == (202, path)
    assert (first.json()["links"], first.headers["retry-after"]) == ({"self": path}, "1")
    whole = client.get(path)  # joins the work
    assert whole.json()["format"] == "camwright-proof"
    assert client.get(path, headers=later).content == whole.content
    assert client.delete(path.removesuffix("/proof.json")).status_code == 204
    assert client.get(path).status_code == 404
