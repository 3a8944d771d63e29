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

from service.examples import LINKAGES as FOLDER
from service.examples import examples
from synthesis import DesignSpec, synthesise
from synthesis.errors import InputError
from synthesis.exporters.linkages import LINKAGE_FILES
from synthesis.exporters.samples.cam import Cam
from synthesis.linkages import LINKAGES
from synthesis.linkages.shaper.mechanism import Shaper

SVG = "{http://www.w3.org/2000/svg}"


def answered(kind: str, name: str, **changes: Any) -> Any:
    linkage, value = LINKAGES[kind], examples(f"{FOLDER}/{kind}")[name]["value"]
    return linkage.work(linkage.spec.model_validate(value | changes), None)


@pytest.fixture(scope="module")
def shaper() -> Any:
    return answered("six-bar-shapers", "p5")


@pytest.fixture(scope="module")
def arm() -> Any:
    return answered("palletising-arms", "irb-660")


def written(kind: str, found: Any, name: str, **options: Any) -> bytes:
    file = LINKAGE_FILES[kind][name]
    return file.write(found, file.options(**options))


def rows(data: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(data.decode())))


def test_the_table_is_the_motion(shaper: Any) -> None:
    table = rows(written("six-bar-shapers", shaper, "motion.csv", points=97))
    assert len(table) == 98
    columns = {name: np.array([float(row[name]) for row in table]) for name in table[0]}
    assert columns["time_s"][-1] == pytest.approx(2.0 * np.pi, rel=1e-12)
    machine = Shaper(125.0, 600.0, 150.0, 275.0, 575.0, "left")
    assert np.allclose(columns["ram_mm"], machine.motion(np.radians(columns["crank_deg"])).ram[0])
    middle = (columns["ram_mm_per_s"][1:] + columns["ram_mm_per_s"][:-1]) / 2.0
    steps = np.diff(columns["ram_mm"]) / np.diff(columns["time_s"])
    assert np.allclose(middle, steps, atol=0.01 * np.max(np.abs(steps)))
    told = json.loads(written("six-bar-shapers", shaper, "motion.json", points=97))
    assert told["columns"][3]["values"] == columns["ram_mm"].tolist()


def test_border_and_poses_as_tables(arm: Any) -> None:
    border = rows(written("palletising-arms", arm, "workspace.csv"))
    assert [row["keeps"] for row in border] == [arc.keeps for arc in arm.regions[0].border]
    assert float(border[1]["radius_mm"]) == arm.regions[0].border[1].radius_mm
    poses = rows(written("palletising-arms", arm, "poses.csv"))
    assert {row["name"] for row in poses} == {"home", "pick", "place"}
    assert sum(int(row["within_limits"]) for row in poses) >= 3


@pytest.mark.parametrize("kind", LINKAGES)
def test_pictures_are_whole_and_their_parts_are_told(kind: str, shaper: Any, arm: Any) -> None:
    found = {"six-bar-shapers": shaper, "palletising-arms": arm}[kind]
    for name in LINKAGE_FILES[kind]:
        if name.endswith(".svg"):
            text = written(kind, found, name, theme="print").decode()
            assert ElementTree.fromstring(text).tag == f"{SVG}svg"
            assert "nan" not in text.replace("animation", "")
    page = written(kind, found, "animation.html").decode()
    frames = json.loads(re.search(r'id="frames">(.*?)</script>', page, re.S).group(1))  # type: ignore[union-attr]
    for part in frames["parts"]:
        assert f'data-part="{part["name"]}"' in page
    for reading in frames["readings"]:
        assert f'id="{reading["name"]}"' in page


def test_the_shapers_parts_stay_together(shaper: Any) -> None:
    """Over the animation: the pin on crank and guide, the ram's pin at the coupler's end."""
    page = written("six-bar-shapers", shaper, "animation.html").decode()
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


def test_a_cam_moves_its_follower_as_the_ram(shaper: Any) -> None:
    """The question as it stands: the follower passes no row by more than the stated tolerance."""
    body = json.loads(written("six-bar-shapers", shaper, "cam.json", points=180, tolerance_mm=0.21))
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
    found = answered("six-bar-shapers", "turning-guide")
    assert not LINKAGE_FILES["six-bar-shapers"]["cam.json"].suits(found)
    with pytest.raises(InputError, match="constant speed"):
        written("six-bar-shapers", found, "cam.json")
