"""The checker accepts what is true of designs, and nothing that is not, whatever the file says."""

import ast
import copy
import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any
from unittest.mock import ANY
from zipfile import ZIP_BZIP2, ZipFile

import pytest

from synthesis import DesignSpec, proof, synthesise
from synthesis.design.design import Conflict
from synthesis.pipeline.proof_file.checker import checker, checker_path
from tests.checker.mutations import mutated, put
from tests.checker.run import verdict
from tests.checker.schema import conforms
from tests.checker.truth import contradiction

EXAMPLES = Path(__file__).resolve().parents[2] / "openapi" / "examples"
MUTANTS = {"example-13-6-sized": 12, "flat-face": 6, "fixed-laws": 12}


def proof_of(name: str, **changes: Any) -> Any:
    body = {**json.loads((EXAMPLES / f"{name}.json").read_text("utf-8"))["value"], **changes}
    return json.loads(json.dumps(proof(synthesise(DesignSpec.model_validate(body)))))


@pytest.fixture(scope="module")
def proofs() -> dict[str, Any]:
    return {name: proof_of(name) for name in MUTANTS}


def refusal_of(name: str, **changes: Any) -> Any:
    """The proof of a question without a cam, whose conflict nobody explains."""
    conflict = Conflict(limits=[], relaxations=[], evidence="", proven=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(f"{synthesise.__module__}.explain", lambda *_: conflict)
        patch.setattr(f"{synthesise.__module__}.prove_over_free_numbers", lambda *_: conflict)
        return proof_of(name, **changes)


@pytest.fixture(scope="module")
def impossible() -> Any:
    return refusal_of("infeasible-on-purpose")


def test_a_pair_without_a_cam_has_its_file(monkeypatch: pytest.MonkeyPatch) -> None:
    conflict = Conflict(limits=[], relaxations=[], evidence="", proven=True)
    monkeypatch.setattr(f"{synthesise.__module__}.explain", lambda *_: conflict)
    monkeypatch.setattr(f"{synthesise.__module__}.prove_over_free_numbers", lambda *_: conflict)
    jerk = {"kind": "jerk", "max_mm_per_s3": 10.0}
    angle = {"kind": "pressure_angle", "rise_deg": 40.0, "return_deg": 40.0}
    document = proof_of("conjugate", limits=[jerk, angle])
    assert document["cam"] is None
    assert [claim["place"] for claim in document["claims"]] == ["infeasible"]


def claims(document: Any) -> dict[str, Any]:
    return {claim["place"]: claim for claim in document["claims"]}


def test_the_checker_is_one_file_of_plain_python_without_floating_point() -> None:
    tree = ast.parse(checker_path().read_text("utf-8"), feature_version=(3, 9))
    imported = {
        name
        for node in ast.walk(tree)
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in (
            [node.module] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
        )
    }
    assert imported == {
        "bisect", "copy", "json", "re", "sys", "zipfile",
        "collections", "fractions", "functools", "itertools", "math",
    }  # fmt: skip
    assert not [
        n for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, float)
    ]
    called = {
        n.func.id
        for n in ast.walk(tree)
        if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
    }
    assert not called & {"float", "eval", "exec", "compile", "__import__"}


def test_a_python_with_nothing_installed_accepts_the_example(proofs: Any, tmp_path: Path) -> None:
    (tmp_path / "proof.json").write_text(json.dumps(proofs["example-13-6-sized"]), "utf-8")
    command = [sys.executable, "-I", "-S", str(checker_path()), "proof.json"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout
    assert "no cam of this question has a base_radius below 34.9009" in found.stdout
    assert found.stdout.count("holds at every cam angle") == 5


def test_an_archive_is_checked_as_a_whole(proofs: Any, impossible: Any, tmp_path: Path) -> None:
    broken = json.loads(json.dumps(impossible))
    broken["question"]["limits"] = []

    def run(*files: bytes) -> tuple[int, str]:
        with ZipFile(tmp_path / "proofs.zip", "w") as archive:
            for number, content in enumerate(files):
                archive.writestr(f"item-{number}.proof.json", content)
        command = [sys.executable, "-I", "-S", str(checker_path()), "proofs.zip"]
        found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        return found.returncode, found.stdout

    sound = [json.dumps(each).encode() for each in (proofs["example-13-6-sized"], impossible)]
    code, text = run(*sound)
    assert (code, text.count("item-"), text.count("claims proven")) == (0, 2, 2), text
    assert run(json.dumps(broken).encode(), *sound)[0] == 1
    assert run(*sound, b"{")[0] == 2
    assert run()[0] == 2


def test_what_is_no_archive_of_proofs_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "no.zip").write_bytes(b"PK")
    with ZipFile(tmp_path / "ends.zip", "w") as archive:
        archive.writestr("early.json", "{}")
        archive.filelist[0].compress_size = archive.filelist[0].file_size = 10_000
    with ZipFile(tmp_path / "bomb.zip", "w", ZIP_BZIP2) as archive:  # of 2 kB, or of a terabyte
        archive.writestr("a.json", "{}")
    for name in ("no.zip", "ends.zip", "bomb.zip", "\udcff.json"):
        command = [sys.executable, "-I", "-S", str(checker_path()), name]
        found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert (found.returncode, found.stderr) == (2, ""), name
        assert "cannot be read" in found.stdout


@pytest.mark.parametrize("name", MUTANTS)
def test_every_claim_of_the_covered_examples_is_proven(proofs: Any, name: str) -> None:
    document = proofs[name]
    assert all(claim["proven"] for claim in document["claims"]), document["claims"]
    assert "note" not in claims(document)["objective/0"]  # the bound is the answer's own
    assert len(json.dumps(document)) < 50_000
    assert verdict(document)[0] == 0
    assert contradiction(document) == ""


def test_that_no_law_keeps_the_limits_is_proven(impossible: Any) -> None:
    assert claims(impossible)["infeasible"]["proven"]
    assert verdict(impossible)[0] == 0


def test_a_bound_cannot_be_raised(proofs: Any) -> None:
    # the proof is sharp: a thousandth more is refused, whatever else the file has
    for document in proofs.values():
        changed = copy.deepcopy(document)
        claims(changed)["objective/0"]["at_least"] *= 1.001
        assert verdict(changed)[0] == 1


@pytest.mark.parametrize("name", MUTANTS)
def test_nothing_false_is_accepted_in_changed_files(proofs: Any, name: str) -> None:
    chance = random.Random(name)
    others = [document for key, document in proofs.items() if key != name]
    for _ in range(MUTANTS[name]):
        document = mutated(proofs[name], others, chance)
        if verdict(document)[0] == 0:
            assert contradiction(document, proofs[name]) == "", document


def test_nothing_false_is_accepted_in_changed_proofs_of_impossibility(impossible: Any) -> None:
    chance, codes = random.Random(7), list[int]()
    for _ in range(60):
        document = mutated(impossible, [], chance)
        codes.append(verdict(document)[0])
        # of the question nothing but what loosens no limit may have changed
        if codes[-1] == 0 and document["question"] != impossible["question"]:
            limit, jerk = (
                each["question"]["limits"][1]["max_mm_per_s3"] for each in (document, impossible)
            )
            assert (
                limit < 1.11 * jerk
                or document["question"]["program"] != impossible["question"]["program"]
            )
    assert codes.count(0) < 40


def test_files_are_as_the_schema_says(proofs: Any, impossible: Any) -> None:
    schema = json.loads(checker_path().with_name("proof.schema.json").read_text("utf-8"))
    documents = [*proofs.values(), impossible, proof_of("fixed-laws")]
    assert all(conforms(document, schema, schema) for document in documents)
    wrong: tuple[tuple[Any, Any], ...] = (
        (("version",), 2), (("version",), True), (("cam", "laws", 0, "degree"), 6),
        (("claims", 1, "proven"), False), (("claims", 0, "at_least"), "34"),
        (("claims", 0, "multipliers", "order"), 4),
        (("claims", 0, "multipliers", "segments", 0, "rows", 0, "multipliers", 0), [0.5]),
    )  # fmt: skip
    for path, value in wrong:
        changed = copy.deepcopy(proofs["example-13-6-sized"])
        put(changed, path, value)
        assert not conforms(changed, schema, schema), path
        assert verdict(changed)[0] == 2, path


def without_a_claim(document: Any) -> None:
    del document["claims"][2]


def with_a_looser_limit(document: Any) -> None:
    document["question"]["limits"][1]["max_mm_per_s3"] *= 1.05


def with_a_stricter_limit(document: Any) -> None:
    document["question"]["limits"][0]["rise_deg"] = 29.9


def with_another_size(document: Any) -> None:
    document["cam"]["size"][1] *= 0.999


def with_a_negative_multiplier(document: Any) -> None:
    rows = claims(document)["objective/0"]["multipliers"]["segments"][0]["rows"]
    rows[0]["multipliers"][3][1] *= -1.0


def with_an_unknown_field(document: Any) -> None:
    document["question"]["follower"]["misalignment_deg"] = 1.0


@pytest.mark.parametrize(
    "change",
    [without_a_claim, with_a_looser_limit, with_a_stricter_limit, with_another_size,
     with_a_negative_multiplier, with_an_unknown_field],
)  # fmt: skip
def test_what_is_not_shown_is_refused_with_its_place(proofs: Any, change: Any) -> None:
    document = copy.deepcopy(proofs["example-13-6-sized"])
    change(document)
    code, said = verdict(document)
    assert code in (1, 2)
    assert said.splitlines()[-1]


@pytest.mark.parametrize(
    "text",
    ["", "{", "[" * 100_000, '{"format": 1e999999999}', '{"a": 1, "a": 2}', '{"format": NaN}',
     '{"format": ' + "9" * 10_000 + "}", "[" + "1," * 100_000 + "1]", "\xff"],
)  # fmt: skip
def test_hostile_files_cannot_be_read(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    judge = checker()
    judge.spent.clear()
    assert judge.check(text.encode("latin-1")) == 2
    assert capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "proven"),
    [("conjugate", 9), ("table", 0), ("tilted-flat-face", 9), ("p3-sized", 7),
     ("oscillating-flat-face", 8), ("quiet-then-small", 7), ("windows-and-points", 10),
     ("constant-velocity", 7)],
)  # fmt: skip
def test_every_design_has_a_file_that_says_what_is_not_covered(name: str, proven: int) -> None:
    document = proof_of(name, proof="quick", tolerance=2e-2)
    assert sum(claim["proven"] for claim in document["claims"]) == proven
    assert all(claim["proven"] or claim["reason"] for claim in document["claims"])
    code, said = verdict(document)
    assert (code, said.splitlines()[-1].split()[0]) == (0, str(proven)), said


def test_a_peak_pressure_angle_cannot_be_raised() -> None:
    limits = [{"kind": "jerk", "max_mm_per_s3": 2.0e6}]
    changes = {"limits": limits, "objective": {"kind": "peak_pressure_angle"}, "tolerance": 5e-3}
    document = proof_of("example-13-6-sized", base_radius_mm={"min": 20.0, "max": 45.0}, **changes)
    assert verdict(document)[0] == 0
    claim = claims(document)["objective/0"]
    assert claim["proven"]
    assert "note" not in claim
    assert contradiction(document) == ""
    claim["at_least"] *= 1.01  # above the cam of the file
    assert verdict(document)[0] == 1


def test_that_no_cam_fits_does_not_depend_on_the_objective() -> None:
    limits = [{"kind": "jerk", "max_mm_per_s3": 2.0e5}]
    changes = {"limits": limits, "objective": {"kind": "peak_pressure_angle"}}
    changes["base_radius_mm"] = {"min": 20.0, "max": 45.0}
    document = refusal_of("example-13-6-sized", **changes)
    assert claims(document)["infeasible"]["proven"]
    assert verdict(document)[0] == 0


def test_what_is_written_takes_no_more_than_a_file_may(monkeypatch: pytest.MonkeyPatch) -> None:
    body = json.loads((EXAMPLES / "fixed-laws.json").read_text("utf-8"))["value"]
    design = synthesise(DesignSpec.model_validate(body))
    assert verdict(proof(design)) == (0, ANY)
    together = checker().spent["coefficients"]
    monkeypatch.setitem(checker().MOST, "coefficients", together - 1)  # enough for each claim
    assert verdict(proof(design)) == (0, ANY)
