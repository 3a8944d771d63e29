"""The archive of a set: what is in it, in which order, and always the same bytes."""

from __future__ import annotations

import hashlib
import io
import json
import math
import zipfile
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from service.contract.examples import examples
from synthesis import CamSet, synthesise_set
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS, MotionOptions, PointOptions, ProfileOptions
from synthesis.exporters.bundle import BundleOptions, bundle, bundle_files, folders
from synthesis.exporters.diagrams.timing import timing_diagram
from tests.studies.cam_sets import INLET, PRESS, body, question

STEEP = PRESS | {
    "base_radius_mm": {"max": 20},
    "limits": [{"kind": "pressure_angle", "rise_deg": 5, "return_deg": 5}],
}
Opened = dict[str, bytes]


@pytest.fixture(scope="module")
def found() -> CamSet:
    return synthesise_set(question())


def opened(cams: CamSet, **options: Any) -> Opened:
    """By an independent reader, checksums included."""
    with zipfile.ZipFile(io.BytesIO(bundle(cams, BundleOptions(**options)))) as archive:
        assert archive.testzip() is None
        return {name: archive.read(name) for name in archive.namelist()}


def points(content: bytes) -> np.ndarray:
    return np.loadtxt(io.BytesIO(content))


def test_names_and_their_order(found: CamSet) -> None:
    per_cam = [
        "design.json", "profile.csv", "shaft-profile.csv", "profile.txt", "shaft-profile.txt",
        "motion.csv",
    ]  # fmt: skip
    inside = [f"{folder}/{name}" for folder in ("01-inlet", "02-press") for name in per_cam]
    expected = ["cam-set.json", "timing.svg", "timing.csv", *inside, "manifest.json"]
    assert list(opened(found)) == expected


def test_the_order_asked_for_does_not_matter(found: CamSet) -> None:
    one = bundle(found, BundleOptions(("txt", "csv"), ("svg", "csv")))
    assert bundle(found, BundleOptions(("csv", "txt", "csv"), ("csv", "svg"))) == one


def test_the_same_set_gives_the_same_bytes(found: CamSet, monkeypatch: pytest.MonkeyPatch) -> None:
    """However it comes, and whenever: no clock and no file system is in the bytes."""
    first = bundle(found, BundleOptions())
    monkeypatch.setattr("time.time", lambda: 2e9)
    monkeypatch.setattr("time.localtime", lambda *_: (2033, 5, 18, 3, 33, 20, 2, 138, 0))
    again = CamSet.model_validate_json(found.model_dump_json())
    assert bundle(again, BundleOptions()) == first
    with zipfile.ZipFile(io.BytesIO(first)) as archive:
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            assert entry.create_system == 3
            assert entry.external_attr >> 16 == 0o100644
            assert not entry.extra


def test_the_manifest_tells_every_byte(found: CamSet) -> None:
    files = opened(found)
    manifest = json.loads(files.pop("manifest.json"))
    assert [each["name"] for each in manifest["files"]] == list(files)
    for each in manifest["files"]:
        content = files[each["name"]]
        assert each["bytes"] == len(content)
        assert each["sha256"] == hashlib.sha256(content).hexdigest()
    assert [cam["folder"] for cam in manifest["cams"]] == folders(found)
    assert [cam["phase_deg"] for cam in manifest["cams"]] == [37.9, -143.2]
    assert manifest["id"] == found.id


def test_the_set_is_in_it(found: CamSet) -> None:
    files = opened(found)
    assert CamSet.model_validate_json(files["cam-set.json"]) == found
    assert files["timing.svg"] == timing_diagram(found)
    assert json.loads(files["02-press/design.json"]) == found.cams[1].design.model_dump(mode="json")


def test_both_frames(found: CamSet) -> None:
    """Own: as the design alone. Shaft: the same points further round and along, in polar terms."""
    files = opened(found)
    for folder, cam in zip(folders(found), found.cams, strict=True):
        own, shaft = (points(files[f"{folder}/{which}.txt"]) for which in
                      ("profile", "shaft-profile"))  # fmt: skip
        alone = PROFILE_FORMATS["txt"].write(cam.design, PointOptions())
        assert files[f"{folder}/profile.txt"] == alone
        assert np.all(own[:, 2] == 0.0)
        assert np.all(shaft[:, 2] == cam.axial_mm)
        by = np.arctan2(shaft[:, 1], shaft[:, 0]) - np.arctan2(own[:, 1], own[:, 0])
        asked_for = math.radians(cam.follower_direction_deg - 90.0 - cam.phase_deg)
        off = (by - asked_for + math.pi) % (2.0 * math.pi) - math.pi
        np.testing.assert_allclose(off, 0.0, rtol=0.0, atol=1e-11)


def test_options_reach_the_files(found: CamSet) -> None:
    files = opened(
        found,
        profile_formats=("txt", "svg"),
        motion_formats=(),
        profile=ProfileOptions(2.0, curve="pitch"),
        motion=MotionOptions(5.0),
    )
    inside = [name.partition("/")[2] for name in files if name.startswith("01-")]
    assert inside == ["design.json", "pitch.txt", "shaft-pitch.txt", "profile.svg"]
    pitch = PROFILE_FORMATS["txt"].write(found.cams[0].design, PointOptions(2.0, curve="pitch"))
    assert files["01-inlet/pitch.txt"] == pitch
    sampling = json.loads(files["manifest.json"])["sampling"]
    assert sampling["curve"] == "pitch"
    assert sampling["points_per_degree"] == 2.0
    assert sampling["motion_points_per_degree"] == 5.0


def test_exact_curves_stand_on_the_shaft_too(found: CamSet) -> None:
    files = opened(found, profile_formats=("dxf", "nurbs.json"), motion_formats=())
    cam = found.cams[1]
    own, shaft = (
        np.array(json.loads(files[f"02-press/{name}.nurbs.json"])["control_points_mm"])
        for name in ("profile", "shaft-profile")
    )
    turn = np.exp(1j * math.radians(cam.turn_deg))
    np.testing.assert_allclose(shaft @ [1.0, 1j, 0.0], turn * (own @ [1.0, 1j, 0.0]), atol=1e-11)
    assert np.all(shaft[:, 2] == cam.axial_mm)
    assert b"CAM_PROFILE" in files["02-press/shaft-profile.dxf"]


def test_the_timing_table(found: CamSet) -> None:
    lines = opened(found)["timing.csv"].decode().splitlines()
    assert lines[0] == "shaft_deg,cam,folder,ends,starts"
    assert lines[1] == "37.9,1,01-inlet,dwell,rise"
    assert lines[3] == "111.8,2,02-press,return,dwell"
    assert len(lines) == 1 + len(found.timing.events)


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("../../etc/passwd", "01-etc-passwd"),
        ("Einlaß Öffner", "01-Einla-Offner"),
        ("凸轮", "01-cam"),
        ("con.", "01-con"),
        ("a" * 150, "01-" + "a" * 40),
    ],
)
def test_folders_are_names_that_every_system_takes(name: str, folder: str) -> None:
    cams = synthesise_set(question(cams=[{"name": name, "spec": INLET}]))
    assert folders(cams) == [folder]


def test_cams_of_one_name_stay_apart() -> None:
    cams = synthesise_set(question(cams=[{"name": "valve", "spec": INLET}] * 3))
    assert folders(cams) == ["01-valve-1", "02-valve-2", "03-valve-3"]
    assert len(opened(cams)) == 3 + 3 * 6 + 1


def test_a_cam_for_which_nothing_fits_has_its_design_alone() -> None:
    cams = synthesise_set(question(cams=[*body()["cams"], {"name": "steep", "spec": STEEP}]))
    names = [name for name in opened(cams) if name.startswith("03-")]
    assert names == ["03-steep/design.json"]


def test_a_set_without_any_cam_has_no_files() -> None:
    cams = synthesise_set(question(cams=[{"spec": STEEP}]))
    with pytest.raises(InputError, match="No cam of this set fits"):
        list(bundle_files(cams, BundleOptions()))


@pytest.fixture(scope="module")
def flanked() -> CamSet:
    """A groove, and a pair of conjugate cams: every flank is part of the set."""
    cams = []
    for name, phase in (("grooved", 71.3), ("conjugate", -38.9)):
        spec = examples()[name]["value"]
        alone = {key: spec[key] for key in spec if key not in ("speed_rpm", "rotation")}
        cams.append(
            {"name": name, "phase_deg": phase, "axial_mm": 7.5, "spec": alone | {"proof": "quick"}}
        )
    return synthesise_set(question(speed_rpm=97.3, rotation="cw", cams=cams))


def test_every_flank_is_there(flanked: CamSet) -> None:
    files = opened(flanked, profile_formats=("txt", "svg"), motion_formats=())
    names = [name.partition("/")[2] for name in files if name.startswith(("01-", "02-"))]
    assert names == [
        "design.json", "profile.txt", "shaft-profile.txt",
        "profile-outer.txt", "shaft-profile-outer.txt", "profile.svg",
        "design.json", "profile.txt", "shaft-profile.txt",
        "profile-counter.txt", "shaft-profile-counter.txt", "profile.svg",
    ]  # fmt: skip
    pitch = opened(
        flanked, profile_formats=("txt",), motion_formats=(), profile=ProfileOptions(curve="pitch")
    )
    names = [name.partition("/")[2] for name in pitch if name.startswith(("01-", "02-"))]
    assert names == [
        "design.json", "pitch.txt", "shaft-pitch.txt",
        "design.json", "pitch.txt", "shaft-pitch.txt", "counter-pitch.txt",
        "shaft-counter-pitch.txt",
    ]  # fmt: skip


def test_every_flank_is_turned_alike(flanked: CamSet) -> None:
    """By its polar angles; clockwise, so by + 71.3° and − 38.9°."""
    files = opened(flanked, profile_formats=("txt",), motion_formats=())
    for folder, turn, flanks in (
        ("01-grooved", 71.3, ("", "-outer")),
        ("02-conjugate", -38.9, ("", "-counter")),
    ):
        for flank in flanks:
            own, shaft = (
                points(files[f"{folder}/{which}{flank}.txt"]) @ [1.0, 1.0j, 0.0]
                for which in ("profile", "shaft-profile")
            )
            np.testing.assert_allclose(
                shaft, own * np.exp(1j * math.radians(turn)), rtol=0.0, atol=1e-9
            )


def test_one_flank_alone_cannot_be_had() -> None:
    with pytest.raises(InputError, match="profile, pitch"):
        BundleOptions(profile=ProfileOptions(curve="inner"))


@pytest.mark.parametrize("options", [{"profile_formats": ("dwg",)}, {"motion_formats": ("xls",)}])
def test_unknown_formats_are_named(options: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"dwg|xls") as caught:
        BundleOptions(**options)
    assert "csv" in caught.value.rule


def test_files_are_made_one_after_the_other(found: CamSet) -> None:
    """So that an archive of fifty cams does not hold fifty cams' files at a time."""
    made: Callable[[], tuple[str, bytes]] = iter(bundle_files(found, BundleOptions())).__next__
    assert [made()[0] for _ in range(2)] == ["cam-set.json", "timing.svg"]


def test_a_cam_of_several_flanks_brings_a_file_for_each() -> None:
    groove = {"closure": {"kind": "groove", "clearance_mm": 0.4}}
    grooved = INLET | {"follower": INLET["follower"] | groove}
    files = opened(
        synthesise_set(question(cams=[{"name": "inlet", "phase_deg": 37.9, "spec": grooved}])),
        profile_formats=("txt", "svg"),
    )
    inside = [name.removeprefix("01-inlet/") for name in files if name.startswith("01-inlet/p")]
    assert inside == ["profile.txt", "profile-outer.txt", "profile.svg"]
    for prefix in ("", "shaft-"):
        inner, outer = (
            points(files[f"01-inlet/{prefix}profile{name}.txt"]) for name in ("", "-outer")
        )
        apart = np.hypot(*(inner - outer)[:, :2].T)
        np.testing.assert_allclose(apart, 2.0 * 9.1 + 0.4, rtol=1e-9)
