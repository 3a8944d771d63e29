"""Flanks as surfaces, read by OpenCASCADE: they lie where rollers touch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

from synthesis.errors import InputError
from synthesis.spatial.files.flanks_step import STEP, SurfaceOptions
from synthesis.spatial.pipeline import synthesise_spatial
from synthesis.spatial.spec import SpatialCamSpec
from tests.exporters import kernel
from tests.spatial.test_cam import body
from tests.spatial.test_flank_files import SIZES, seen_by_roller

CAM = synthesise_spatial(SpatialCamSpec(**body(mesh_angle_deg=53.7)))
TOLERANCE = 0.4  # µm


def test_a_kernel_reads_surfaces_that_touch_the_rollers(tmp_path: Path) -> None:
    file = STEP.whole(CAM, SurfaceOptions(tolerance_um=TOLERANCE))
    faces = TopExp_Explorer(
        kernel.shape(file.data, ".step", tmp_path), TopAbs_ShapeEnum.TopAbs_FACE
    )
    names = [line.split("'")[1] for line in file.data.decode().splitlines()
             if "B_SPLINE_SURFACE_WITH_KNOTS" in line]  # fmt: skip
    assert set(names) == {wall.name for wall in CAM.walls}
    rng, read = np.random.default_rng(5), 0
    for name in names:
        surface = BRep_Tool.Surface_s(TopoDS.Face(faces.Current()))
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
    assert read == int(file.told["Surfaces"])
    assert not faces.More()
    assert float(file.told["Surface-Error-Mm"]) <= 1e-3 * TOLERANCE


def test_a_finer_tolerance_brings_them_nearer() -> None:
    told = [
        float(STEP.whole(CAM, SurfaceOptions(tolerance_um=each)).told["Surface-Error-Mm"])
        for each in (1.0, 0.01)
    ]
    assert told[1] <= 1e-5 < told[0] <= 1e-3


def test_an_unknown_flank_is_refused() -> None:
    with pytest.raises(InputError, match="The flanks of this cam are"):
        STEP.write(CAM, SurfaceOptions(flank="7R"))
