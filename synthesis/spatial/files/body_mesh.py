"""The whole cam as a closed mesh of triangles: what files of a body are written from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from synthesis.errors import InputError
from synthesis.spatial.blank import Blank, BlankOptions
from synthesis.spatial.body import body_of, flank_error
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.grooves import Cuts
from synthesis.spatial.mesh import Mesh, mesh_of

Rows = Annotated[
    float, Field(ge=0.1, le=20.0, description="Rows of points per degree of cam angle.")
]
Levels = Annotated[
    int, Field(ge=2, le=100, description="Rows of points from a rib's top to the floor.")
]


@dataclass(frozen=True, kw_only=True)
class MeshOptions(BlankOptions):
    """As ``BlankOptions``, and how fine the mesh is.

    Attributes:
        points_per_degree: rows of points round the cam. depths: rows from a rib's top to the floor.
    """

    points_per_degree: Rows = 1.0
    depths: Levels = 7


@dataclass(frozen=True, eq=False)
class Meshed:
    """A mesh, and how far the true surface is from it.

    Attributes:
        error: largest distance seen [mm].
    """

    mesh: Mesh
    error: float

    @property
    def told(self) -> Mapping[str, str]:
        """What every file of a body tells besides."""
        return {
            "Surface-Error-Mm": f"{self.error:.3g}",
            "Volume-Mm3": f"{self.mesh.volume:.10g}",
            "Triangles": str(len(self.mesh.triangles)),
        }


def meshed(design: SpatialDesign, options: MeshOptions, most: int) -> Meshed:
    """The cam's surface, of at most so many triangles.

    Raises:
        InputError: there may be more, told before anything is computed; or there is no body.
    """
    _check(design, options, most)
    cuts = Cuts.of(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, options.depths)
    body = body_of(cuts, blank, round(360.0 * options.points_per_degree))
    return Meshed(mesh_of(body), flank_error(cuts, body))


def _check(design: SpatialDesign, options: MeshOptions, most: int) -> None:
    parts = design.spec.machine.chart(design.cam.sizes).parts
    grooves = len(design.walls) // 2 + 2
    columns = (grooves + 1) * 2 * (options.depths - 1 + parts)
    count = 2 * columns * 360.0 * options.points_per_degree
    if count > most:
        fewer = options.points_per_degree * most / count
        raise InputError(
            "/points_per_degree",
            options.points_per_degree,
            f"This may make {count:.2g} triangles; a file has at most {most}.",
            f"Ask for at most {fewer:.3g}, or for fewer depths.",
        )
