"""A cam's body as a solid of its true surfaces, read by OpenCASCADE and touched by its rollers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.exporters.curves.step import Entities
from synthesis.exporters.exporter import FileContent
from synthesis.machines.spatial.body import Blank, BlankOptions, build_body, triangulate
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.step import BODY, FacetedOptions, build_solid
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.solid.geometry import NotSmooth, Shell, line
from tests.exporters import kernel
from tests.exporters.kernel import OCP
from tests.machines.spatial.drums import INNER, designed
from tests.machines.spatial.test_body import CAMS, made, rollers_clear

Array = NDArray[np.float64]
BETWEEN = 0.02  # what a wall may be off between two of the cam angles tried [mm]
GLOBOIDAL = "turret, left, cut at a width"
ASKED: dict[str, dict[str, Any]] = {
    "slide in a groove": {"tolerance_um": 1.0, "bore_mm": 23.1},
    "arm astride a rib": {"tolerance_um": 2.0},
    GLOBOIDAL: {"tolerance_um": 30.0, **CAMS[GLOBOIDAL][1]},
}


@dataclass(frozen=True, eq=False)
class Read:
    """What was asked, the file, and what a kernel makes of it."""

    name: str
    design: SpatialDesign
    file: FileContent
    shape: Any

    @property
    def tolerance(self) -> float:
        """[mm]"""
        return float(1e-3 * ASKED[self.name]["tolerance_um"])


@pytest.fixture(scope="module", params=ASKED)
def read(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Read:
    name = request.param
    design = made(CAMS[GLOBOIDAL][0]) if name == GLOBOIDAL else designed(name)
    file = BODY.content(design, FacetedOptions(**ASKED[name]))
    return Read(name, design, file, kernel.shape(file.data, ".step", tmp_path_factory.mktemp("s")))


def test_a_kernel_reads_one_sound_closed_solid(read: Read) -> None:
    assert read.shape.ShapeType() == OCP.TopAbs.TopAbs_ShapeEnum.TopAbs_SOLID
    assert OCP.BRepCheck.BRepCheck_Analyzer(read.shape).IsValid()
    shells = OCP.TopExp.TopExp_Explorer(read.shape, OCP.TopAbs.TopAbs_ShapeEnum.TopAbs_SHELL)
    assert OCP.BRep.BRep_Tool.IsClosed_s(shells.Current())
    shells.Next()
    assert not shells.More()


def test_its_volume_is_that_of_ever_finer_meshes(read: Read) -> None:
    question = {key: value for key, value in ASKED[read.name].items() if key != "tolerance_um"}
    cuts = GrooveSections(read.design.cam, read.design.spec.machine, straight=True)
    coarse, fine = (
        triangulate(
            build_body(cuts, Blank.of(cuts, BlankOptions(**question), 1 + 3 * k), 60 * k, 4 * k)
        )
        for k in (1, 2)
    )
    reported = OCP.GProp.GProp_GProps()
    OCP.BRepGProp.BRepGProp.VolumeProperties_s(read.shape, reported, 1e-6)
    meant = fine.volume + (fine.volume - coarse.volume) / 3.0
    assert reported.Mass() == pytest.approx(meant, rel=5e-4)
    assert abs(reported.Mass() - meant) < 0.2 * abs(reported.Mass() - fine.volume)


def _walls(shape: Any) -> list[Array]:
    """Points (3, n) of every B-spline face, away from its edges."""
    found, faces = [], OCP.TopExp.TopExp_Explorer(shape, OCP.TopAbs.TopAbs_ShapeEnum.TopAbs_FACE)
    at = np.linspace(0.013, 0.987, 9)
    while faces.More():
        surface = OCP.BRep.BRep_Tool.Surface_s(OCP.TopoDS.TopoDS.Face(faces.Current()))
        if isinstance(surface, OCP.Geom.Geom_BSplineSurface):
            points = [surface.Value(float(u), float(v)) for u in at for v in at]
            found.append(np.array([[p.X(), p.Y(), p.Z()] for p in points]).T)
        faces.Next()
    return found


def _where_touched(design: SpatialDesign, points: Array) -> NDArray[np.bool_]:
    """Which points (n, 3) of walls lie where rollers reach."""
    sizes, machine = design.dimensions, design.spec.machine
    away = np.hypot(points[:, 0], points[:, 1])
    if design.machine != "globoidal_indexer":
        return np.asarray(away > np.hypot(INNER, sizes["roller_radius_mm"]))
    width: float = machine.roller_width_mm  # type: ignore[union-attr]
    deep = np.hypot(sizes["centre_distance_mm"] - away, points[:, 2])
    return np.asarray(deep < sizes["roller_inner_mm"] + width)


def test_its_walls_are_touched_and_not_cut_by_rollers(read: Read) -> None:
    """By rollers of which only the motion and the axes are known, over a whole turn."""
    walls = np.concatenate(_walls(read.shape), axis=1).T
    walls = walls[_where_touched(read.design, walls)]
    assert len(walls) > 500
    clear = rollers_clear(read.design, walls)
    assert clear.min() > -1.5 * read.tolerance
    assert np.max(clear) < 1.5 * read.tolerance + BETWEEN


def test_faces_look_outwards_and_their_loops_run_counter_clockwise() -> None:
    """Kernels turn what looks inwards, and do not say so: the file's own faces are looked at."""
    design, bore = designed("slide in a groove"), 23.1
    question = FacetedOptions(form="smooth", bore_mm=bore)
    shell = build_solid(design, question, 1e-3)[0]
    middle = np.mean(list(shell.vertices.values()), axis=0)
    share, holes = np.linspace(0.0, 1.0, 40), 0
    for surface, loops, outwards in shell.faces:
        rings = [
            np.concatenate([shell.edges[key][2].points(share if along else 1.0 - share)
                            for key, along in loop])
            for loop in loops
        ]  # fmt: skip
        place = rings[0][np.argmax(rings[0] @ (np.mean(rings[0], axis=0) * [1.0, 1.0, 0.0]))]
        normal = surface.normal(place) * (1.0 if outwards else -1.0)
        areas = [np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) for ring in rings]
        assert areas[0] @ normal > 0.0
        assert all(area @ normal < 0.0 for area in areas[1:])
        holes += len(areas) - 1
        away = np.array([place[0], place[1], 0.0])
        surface.to_step(data := Entities())
        *_, entity = data.lines()
        if surface.spline is not None:
            point = surface.spline(np.array([0.5, 0.5]))
            step = 0.05 * normal / np.linalg.norm(normal)
            inside, outside = rollers_clear(design, np.array([point - step, point + step]))
            assert inside > 0.04 > -0.04 > outside
        elif "CYLINDRICAL_SURFACE" in entity:
            bored = np.hypot(*away[:2]) < 0.51 * bore
            assert (normal @ away < 0.0) == bored
        else:
            assert normal[2] * (place[2] - middle[2]) > 0.0
    assert holes == 2
    lines = BODY.content(design, question).data.splitlines()
    senses = [line.endswith(b".T.);") for line in lines if b"=ADVANCED_FACE(" in line]
    assert senses == [outwards for _, _, outwards in shell.faces]


def test_what_it_is_stands_in_the_header(read: Read) -> None:
    head = read.file.data.partition(b"DATA;")[0].decode()
    assert read.file.metadata["Body"] == "smooth"
    error = float(read.file.metadata["Surface-Error-Mm"])
    assert 0.0 < error <= read.tolerance
    assert f"a solid of its true surfaces, walls within {error:.3g} mm" in head
    assert read.file.data.count(b"=ADVANCED_FACE(") == int(read.file.metadata["Faces"])


def test_what_has_no_smooth_solid_is_faceted_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    design = designed("slide in a groove")
    near = FacetedOptions(tolerance_um=0.1, points_per_degree=0.2)
    monkeypatch.setattr("synthesis.machines.spatial.solid.sheets.MAX_LINES", 20)
    assert BODY.content(design, near).metadata["Body"] == "faceted"
    question = FacetedOptions(form="smooth", tolerance_um=0.1)
    with pytest.raises(
        InputError, match=r"no smooth solid: a wall is approximated to .* mm"
    ) as reported:
        BODY.content(design, question)
    assert reported.value.field == "/form"


def test_a_shell_that_is_open_is_none() -> None:
    shell, corners = Shell(), np.eye(3)
    for k in range(3):
        ends = corners[k], corners[(k + 1) % 3]
        shell.join((k,), ("corner", k), ("corner", (k + 1) % 3), line(*ends))
    with pytest.raises(NotSmooth, match="not closed"):
        shell.check()
    with pytest.raises(NotSmooth, match="do not close"):
        shell.chained([(0,), (1,)])
