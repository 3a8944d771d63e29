"""A cam's body as a faceted solid, read by OpenCASCADE: one, sound, closed, the mesh's volume."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent
from synthesis.machines.spatial.body import Mesh
from synthesis.machines.spatial.files import step
from synthesis.machines.spatial.files.step import BODY, FacetedOptions, merge_planar_faces
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.exporters import kernel
from tests.exporters.kernel import OCP
from tests.machines.spatial.drums import SAMPLES
from tests.machines.spatial.test_cam import body

Array = NDArray[np.float64]
CAMS: dict[str, tuple[SpatialCamSpec, dict[str, Any]]] = {
    "groove, flat where it rests": (
        SAMPLES["slide in a groove"].spec(),
        {"form": "faceted", "points_per_degree": 0.17, "depths": 3, "bore_mm": 23.1},
    ),
    "turret, ribs that run out of the faces": (
        SpatialCamSpec(**body(mesh_angle_deg=52.3)),
        {
            "form": "faceted",
            "points_per_degree": 0.1,
            "depths": 2,
            "bore_mm": 41.3,
            "width_mm": 103.7,
        },
    ),
}


@pytest.fixture(scope="module", params=CAMS)
def file(request: pytest.FixtureRequest) -> FileContent:
    spec, question = CAMS[request.param]
    return BODY.content(synthesise_spatial(spec), FacetedOptions(**question))


def test_a_kernel_reads_one_sound_closed_solid(file: FileContent, tmp_path: Path) -> None:
    read = kernel.shape(file.data, ".step", tmp_path)
    assert read.ShapeType() == OCP.TopAbs.TopAbs_ShapeEnum.TopAbs_SOLID
    assert OCP.BRepCheck.BRepCheck_Analyzer(read).IsValid()
    shells = OCP.TopExp.TopExp_Explorer(read, OCP.TopAbs.TopAbs_ShapeEnum.TopAbs_SHELL)
    assert OCP.BRep.BRep_Tool.IsClosed_s(shells.Current())
    shells.Next()
    assert not shells.More()
    reported = OCP.GProp.GProp_GProps()
    OCP.BRepGProp.BRepGProp.VolumeProperties_s(read, reported)
    assert reported.Mass() == pytest.approx(float(file.metadata["Volume-Mm3"]), rel=1e-9)


class Read:
    """The entities of a faceted solid, by the file's own numbers."""

    def __init__(self, file: FileContent) -> None:
        rows = re.findall(r"^#(\d+)=(\w+)\('',(.*)\);$", file.data.decode(), re.MULTILINE)
        self.given = {int(number): (kind, given) for number, kind, given in rows}

    def place(self, number: int) -> Array:
        return np.array(re.findall(r"[-\d.E]+", self.given[number][1]), dtype=float)

    def used(self, number: int) -> list[int]:
        return [int(each) for each in re.findall(r"#(\d+)", self.given[number][1])]

    def faces(self) -> list[tuple[Array, list[list[int]]]]:
        """Normal of the plane and points of the loops of every face."""
        found = []
        for number, (kind, _) in self.given.items():
            if kind == "FACE_SURFACE":
                *bounds, plane = self.used(number)
                _, axis = self.used(self.used(plane)[0])
                loops = [self.used(self.used(bound)[0]) for bound in bounds]
                found.append((self.place(axis), loops))
        return found


def test_every_edge_is_run_once_each_way(file: FileContent) -> None:
    loops = [loop for _, each in Read(file).faces() for loop in each]
    ends = [pair for loop in loops for pair in zip(loop, [*loop[1:], loop[0]], strict=True)]
    assert len(set(ends)) == len(ends)
    assert {(b, a) for a, b in ends} == set(ends)


def test_faces_look_outwards(file: FileContent) -> None:
    """Kernels turn what looks inwards, and do not say so: the file's own volume is not."""
    read, volume = Read(file), 0.0
    for normal, loops in read.faces():
        points = [np.array([read.place(each) for each in loop]) for loop in loops]
        areas = [0.5 * np.cross(each, np.roll(each, -1, axis=0)).sum(axis=0) for each in points]
        area = np.sum(areas, axis=0)
        assert area @ normal == pytest.approx(np.linalg.norm(area), rel=1e-6)
        assert areas[0] @ normal >= area @ normal  # holes run the other way
        volume += float(area @ points[0][0]) / 3.0
    assert volume == pytest.approx(float(file.metadata["Volume-Mm3"]), rel=1e-9)


def test_what_is_flat_across_the_axis_is_one_face(file: FileContent) -> None:
    faces, triangles = (int(file.metadata[name]) for name in ("Faces", "Triangles"))
    assert file.data.count(b"=FACE_SURFACE(") == faces < 0.99 * triangles
    assert file.data.count(b"=FACE_BOUND(") == 2  # the bore in either end


HOLED = [(0, 0), (4, 0), (4, 4), (0, 4), (2, 1), (1, 2), (1, 1)]


@pytest.mark.parametrize(
    ("triangles", "faces"),
    [
        ([(0, 1, 4), (1, 2, 4), (4, 2, 5), (2, 3, 5), (3, 0, 5), (0, 6, 5), (0, 4, 6)], 1),
        ([(0, 1, 4), (1, 2, 4), (4, 2, 5), (2, 3, 5), (3, 0, 5)], 5),  # the hole meets the rim
    ],
)
@pytest.mark.parametrize("way", [1, -1])
def test_a_plane_with_a_hole(triangles: list[tuple[int, ...]], faces: int, way: int) -> None:
    points = np.column_stack([np.array(HOLED, dtype=float), np.full(7, 3.7)])
    found = merge_planar_faces(Mesh(points, np.array(triangles)[:, ::way]))
    assert len(found) == faces
    assert all(each.normal.tolist() == [0.0, 0.0, way] for each in found)
    if faces == 1:
        outer, hole = found[0].loops
        turned = outer[outer.index(0) :] + outer[: outer.index(0)]
        assert turned == ([0, 1, 2, 3] if way > 0 else [0, 3, 2, 1])
        assert (set(outer), set(hole)) == ({0, 1, 2, 3}, {4, 5, 6})


def test_the_header_says_what_it_is(file: FileContent) -> None:
    head = file.data.partition(b"DATA;")[0].decode()
    assert "faceted" in head
    assert "flanks.step" in head
    assert f"{file.metadata['Surface-Error-Mm']} mm measured to the true surface" in head


def test_a_file_too_large_is_refused_before_it_is_made() -> None:
    design = synthesise_spatial(CAMS["groove, flat where it rests"][0])
    with pytest.raises(InputError, match="at most 100000"):
        BODY.write(design, FacetedOptions(form="faceted", points_per_degree=9.3, depths=9))


def test_a_face_too_thin_for_a_kernel_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    corners = np.array([(0.0, 0.0, 0.0), (7.3, 0.0, 0.0), (3.1, 4e-8, 0.0), (3.1, 2.0, 5.0)])
    thin = Mesh(corners, np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]))
    monkeypatch.setattr(step, "mesh_body", lambda *_: (thin, {}))
    design = synthesise_spatial(CAMS["groove, flat where it rests"][0])
    with pytest.raises(InputError, match="narrowest face would be 4e-08 mm"):
        BODY.write(design, FacetedOptions(form="faceted"))
