"""Flanks as surfaces, read by OpenCASCADE: they lie where rollers touch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from synthesis.errors import InputError
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.step import FLANKS, SurfaceOptions
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.exporters import kernel
from tests.exporters.kernel import OCP
from tests.machines.spatial.test_cam import body
from tests.machines.spatial.test_flank_files import SIZES, seen_by_roller

TOLERANCE = 0.4  # µm


@pytest.fixture(scope="module")
def cam() -> SpatialDesign:
    return synthesise_spatial(SpatialCamSpec(**body(mesh_angle_deg=53.7)))


def test_a_kernel_reads_surfaces_that_touch_the_rollers(cam: SpatialDesign, tmp_path: Path) -> None:
    file = FLANKS.content(cam, SurfaceOptions(tolerance_um=TOLERANCE))
    faces = OCP.TopExp.TopExp_Explorer(
        kernel.shape(file.data, ".step", tmp_path), OCP.TopAbs.TopAbs_ShapeEnum.TopAbs_FACE
    )
    names = [line.split("'")[1] for line in file.data.decode().splitlines()
             if "B_SPLINE_SURFACE_WITH_KNOTS" in line]  # fmt: skip
    assert set(names) == {wall.name for wall in cam.walls}
    rng, read = np.random.default_rng(5), 0
    for name in names:
        surface = OCP.BRep.BRep_Tool.Surface_s(OCP.TopoDS.TopoDS.Face(faces.Current()))
        low, high, inner, outer = surface.Bounds()
        assert (inner, outer) == pytest.approx((SIZES["inner"], SIZES["outer"]))
        theta, rho = rng.uniform(low, high, 40), rng.uniform(inner, outer, 40)
        values = [surface.Value(u, v) for u, v in zip(theta, rho, strict=True)]
        points = np.array([[point.X(), point.Y(), point.Z()] for point in values])
        away, _, across = seen_by_roller(points, theta, int(name[:-1]))
        assert away == pytest.approx(SIZES["radius"], abs=1e-3 * TOLERANCE)
        assert np.all(across > 0.0) == (name[-1] == "R")
        faces.Next()
        read += 1
    assert read == int(file.metadata["Surfaces"])
    assert not faces.More()
    assert float(file.metadata["Surface-Error-Mm"]) <= 1e-3 * TOLERANCE


def test_a_finer_tolerance_brings_them_nearer(cam: SpatialDesign) -> None:
    reported = [
        float(FLANKS.content(cam, SurfaceOptions(tolerance_um=each)).metadata["Surface-Error-Mm"])
        for each in (1.0, 0.01)
    ]
    assert reported[1] <= 1e-5 < reported[0] <= 1e-3


def test_an_unknown_flank_is_refused(cam: SpatialDesign) -> None:
    with pytest.raises(InputError, match="The flanks of this cam are"):
        FLANKS.write(cam, SurfaceOptions(flank="7R"))
