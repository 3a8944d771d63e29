"""Files of linkages: tables, pictures that move as the machine does, a cam for the ram."""

from __future__ import annotations

import csv
import io
import json
import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from service.contract.examples import examples
from synthesis import DesignSpec, synthesise
from synthesis.errors import InputError
from synthesis.exporters.samples.cam import Cam
from synthesis.machines.linkages import LINKAGES
from synthesis.machines.linkages.files import LINKAGE_FILES
from synthesis.machines.linkages.shaper.mechanism import Shaper

SVG = "{http://www.w3.org/2000/svg}"


def solve_example(kind: str, name: str, **changes: Any) -> Any:
    linkage, value = LINKAGES[kind], examples(f"linkages/{kind}")[name]["value"]
    return linkage.solve(linkage.spec.model_validate(value | changes), None)


@pytest.fixture(scope="module")
def shaper() -> Any:
    return solve_example("six-bar-shapers", "p5")


@pytest.fixture(scope="module")
def arm() -> Any:
    return solve_example("palletising-arms", "irb-660")


def file_of(kind: str, found: Any, name: str, **options: Any) -> bytes:
    file = LINKAGE_FILES[kind][name]
    return file.write(found, file.options(**options))


def rows(data: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(data.decode())))


def test_the_table_is_the_motion(shaper: Any) -> None:
    table = rows(file_of("six-bar-shapers", shaper, "motion.csv", points=97))
    assert len(table) == 98
    columns = {name: np.array([float(row[name]) for row in table]) for name in table[0]}
    assert columns["time_s"][-1] == pytest.approx(2.0 * np.pi, rel=1e-12)
    machine = Shaper(125.0, 600.0, 150.0, 275.0, 575.0, "left")
    assert np.allclose(columns["ram_mm"], machine.motion(np.radians(columns["crank_deg"])).ram[0])
    middle = (columns["ram_mm_per_s"][1:] + columns["ram_mm_per_s"][:-1]) / 2.0
    steps = np.diff(columns["ram_mm"]) / np.diff(columns["time_s"])
    assert np.allclose(middle, steps, atol=0.01 * np.max(np.abs(steps)))
    document = json.loads(file_of("six-bar-shapers", shaper, "motion.json", points=97))
    assert document["columns"][0]["meaning"] == "angle turned by the crank"
    assert document["columns"][3]["values"] == columns["ram_mm"].tolist()


def test_border_and_poses_as_tables(arm: Any) -> None:
    border = rows(file_of("palletising-arms", arm, "workspace.csv"))
    assert [row["keeps"] for row in border] == [arc.keeps for arc in arm.regions[0].border]
    assert float(border[1]["radius_mm"]) == arm.regions[0].border[1].radius_mm
    poses = rows(file_of("palletising-arms", arm, "poses.csv"))
    assert {row["name"] for row in poses} == {"home", "pick", "place"}
    assert sum(int(row["within_limits"]) for row in poses) >= 3


@pytest.mark.parametrize("kind", LINKAGES)
def test_pictures_are_whole_and_their_parts_are_told(kind: str, shaper: Any, arm: Any) -> None:
    found = {"six-bar-shapers": shaper, "palletising-arms": arm}[kind]
    for name in LINKAGE_FILES[kind]:
        if name.endswith(".svg"):
            text = file_of(kind, found, name, theme="print").decode()
            assert ElementTree.fromstring(text).tag == f"{SVG}svg"
            assert "nan" not in text.replace("animation", "")
    page = file_of(kind, found, "animation.html").decode()
    frames = json.loads(re.search(r'id="frames">(.*?)</script>', page, re.S).group(1))  # type: ignore[union-attr]
    for part in frames["parts"]:
        assert f'data-part="{part["name"]}"' in page
    for reading in frames["readings"]:
        assert f'id="{reading["name"]}"' in page


def test_the_shapers_parts_stay_together(shaper: Any) -> None:
    """Over the animation: the pin on crank and guide, the ram's pin at the coupler's end."""
    page = file_of("six-bar-shapers", shaper, "animation.html").decode()
    frames = json.loads(re.search(r'id="frames">(.*?)</script>', page, re.S).group(1))  # type: ignore[union-attr]
    parts = {part["name"]: part["columns"] for part in frames["parts"]}

    def column(name: str, k: int = 0) -> np.ndarray:
        given = parts[name][k]
        return np.linspace(*given, 721) if len(given) == 2 else np.array(given)

    def from_turn(name: str, length: float) -> np.ndarray:
        angle = np.radians(column(name))
        return length * np.stack([np.cos(angle), np.sin(angle)])

    block = np.stack([column("block"), column("block", 1)])
    assert np.allclose(block, from_turn("crank", 125.0) + np.array([[0.0], [275.0]]), atol=2e-2)
    end = np.stack([column("coupler"), column("coupler", 1)])
    assert np.allclose(end, from_turn("guide", 600.0), atol=2e-2)
    ram = np.stack([column("ram"), np.full(721, 575.0)])
    assert np.allclose(ram, end + from_turn("coupler-turn", 150.0), atol=2e-2)


def test_the_shaper_as_data_is_the_shaper_of_the_page(shaper: Any) -> None:
    """Its turn in 360 steps, its parts named in its shapes, all of it in its extent."""
    document = json.loads(file_of("six-bar-shapers", shaper, "animation.json"))
    parts = {part["name"]: part["columns"] for part in document["parts"]}
    assert all(f'data-part="{name}"' in document["shapes"] for name in parts)
    angles = np.radians(np.arange(361.0))
    ram = Shaper(125.0, 600.0, 150.0, 275.0, 575.0, "left").motion(angles).ram[0]
    assert np.allclose(np.array(parts["ram"][0]) / document["scale"], ram, atol=1e-4)
    left, _, right, _ = document["extent"]
    assert left < min(parts["ram"][0]) < max(parts["coupler"][0]) < right


def test_the_arms_parts_bring_its_tool_to_every_pose() -> None:
    """In each solution: from the shoulder along both arms to the target, mirrored where over."""
    wide = {"opening_deg": {"min": -180, "max": 180}, "upper_arm_deg": {"min": -150, "max": 130},
            "forearm_deg": {"min": -170, "max": 170}}  # fmt: skip
    places = [{"kind": "point", "x_mm": 700.0, "y_mm": -310.0, "z_mm": 1450.0},
              {"kind": "joints", "base_deg": 33.0, "upper_arm_deg": -90.0, "forearm_deg": 60.0},
              {"kind": "point", "x_mm": 6000.0, "z_mm": 0.0}]  # fmt: skip
    found = solve_example("palletising-arms", "irb-660", poses=places, **wide)
    document = json.loads(file_of("palletising-arms", found, "animation.json"))
    spec, scale = found.spec, document["scale"]
    mirrors = []
    for pose, drawn in zip(found.poses, document["poses"], strict=True):
        assert np.allclose(
            np.array(drawn["plan_target"]) / scale, [pose.x_mm, pose.y_mm], atol=0.01
        )
        for one in drawn["solutions"]:
            at = {part["name"]: np.array(part["at"]) for part in one["parts"]}
            up, fore = (np.radians(at[name][0]) for name in ("upper", "fore"))
            wrist = at["elbow"] / scale + spec.forearm_mm * np.array([np.cos(fore), np.sin(fore)])
            tool = wrist + np.array([spec.wrist_offset_mm, -spec.tool_mm])
            assert np.allclose(at["wrist"] / scale, wrist, atol=0.02)
            shoulder = np.array([spec.shoulder_offset_mm, spec.shoulder_height_mm])
            arm = np.array([np.cos(up), np.sin(up)])
            assert np.allclose(at["elbow"] / scale, shoulder + spec.upper_arm_mm * arm, atol=0.02)
            assert np.allclose(
                tool * [one["mirror"], 1.0], np.array(drawn["target"]) / scale, atol=0.03
            )
            base = np.radians(one["base_deg"])
            assert np.allclose(
                tool[0] * np.array([np.cos(base), np.sin(base)]), [pose.x_mm, pose.y_mm], atol=0.03
            )
            mirrors.append(one["mirror"])
    assert {1, -1} == set(mirrors)
    assert document["poses"][2]["solutions"] == []


def test_where_the_arms_are_in_line_is_drawn() -> None:
    """An arc about the shoulder, carried to the tool, as long as both arms."""
    wide = {"opening_deg": {"min": -80.0, "max": 130.0}, "forearm_deg": {"min": -70, "max": 120}}
    found = solve_example("palletising-arms", "irb-660", **wide)
    text = file_of("palletising-arms", found, "workspace.svg").decode()
    (way,) = re.findall(
        r'class="line limit" d="M([-\d. ]+)A([\d.]+) [\d.]+ 0 0 \d ([-\d. ]+)"', text
    )
    start, radius, end = (np.array([float(x) for x in part.split()]) * 100.0 for part in way)
    spec, (line,) = found.spec, found.singular
    assert radius[0] == pytest.approx(spec.upper_arm_mm + spec.forearm_mm, abs=0.02)
    ends = [tuple(np.radians(pair)) for pair in (line.from_deg, line.to_deg)]
    for point, (upper, fore) in zip((start, end), ends, strict=True):
        tool = spec.arm.tool_point(upper, fore)
        assert np.allclose(point, [tool.real, tool.imag], atol=0.02)


def test_a_base_that_turns_part_of_the_way_reaches_a_sector() -> None:
    """From above: ends of the arcs, and what lies behind the base."""
    found = solve_example("palletising-arms", "irb-660", base_deg={"min": -40.0, "max": 170.0})
    document = json.loads(file_of("palletising-arms", found, "animation.json"))
    path = re.search(r'class="outline body" d="(.*?)"', document["plan"]["shapes"]).group(1)  # type: ignore[union-attr]
    points = np.array(
        [[float(x) for x in p.split()[-2:]] for p in re.split("[MAL]", path.strip("MZ"))]
    )
    away, angle = (
        np.hypot(*points.T) / document["scale"],
        np.degrees(np.arctan2(points[:, 1], points[:, 0])),
    )
    (region,) = found.regions
    assert np.allclose(away[:4], region.r_max.value_mm, atol=0.02)
    assert np.allclose(away[4:], region.r_min.value_mm, atol=0.02)
    assert np.allclose(angle, [-40, 30, 100, 170, 170, 100, 30, -40], atol=1e-2)


def test_a_cam_moves_its_follower_as_the_ram(shaper: Any) -> None:
    """The question as it stands: the follower passes no row by more than the stated tolerance."""
    body = json.loads(file_of("six-bar-shapers", shaper, "cam.json", points=180, tolerance_mm=0.21))
    (table,) = body["program"]
    assert table["tolerance_mm"] == 0.21
    design = synthesise(DesignSpec.model_validate(body | {"tolerance": 0.02}))
    assert design.status == "optimal"
    assert max(one.value for one in design.extremes if one.limit == "table_deviation") <= 0.21
    angles = np.radians(np.arange(180) * 2.0)
    machine = Shaper(125.0, 600.0, 150.0, 275.0, 575.0, "left")
    ram = machine.motion(angles).ram[0]
    follower = Cam.of(design).derivatives(angles, np.zeros(180, dtype=bool))[0]
    off = follower - ram
    assert np.ptp(off) <= 2.0 * 0.21 * (1.0 + 1e-9)
    assert np.ptp(off) >= 0.21  # it uses what it may


def test_a_crank_that_speeds_up_has_no_cam() -> None:
    found = solve_example("six-bar-shapers", "turning-guide")
    assert not LINKAGE_FILES["six-bar-shapers"]["cam.json"].suits(found)
    with pytest.raises(InputError, match="constant speed"):
        file_of("six-bar-shapers", found, "cam.json")
