"""The shell in STEP's words."""

from __future__ import annotations

from synthesis.exporters.curves.part21 import Entities, many
from synthesis.spatial.smooth.geometry import point
from synthesis.spatial.smooth.shell import Face, Key, Shell


def told_shell(data: Entities, shell: Shell) -> str:
    """The CLOSED_SHELL with all that it needs."""
    corners = {
        key: data.add("VERTEX_POINT", "''", point(data, place))
        for key, place in shell.vertices.items()
    }
    edges = {
        key: data.add(
            "EDGE_CURVE",
            "''",
            corners[edge.first],
            corners[edge.last],
            edge.curve.told(data),
            ".T.",
        )
        for key, edge in shell.edges.items()
    }
    return data.add("CLOSED_SHELL", "''", many([_face(data, face, edges) for face in shell.faces]))


def _face(data: Entities, face: Face, edges: dict[Key, str]) -> str:
    bounds = []
    for i, loop in enumerate(face.loops):
        runs = [
            data.add("ORIENTED_EDGE", "''", "*", "*", edges[key], _flag(along))
            for key, along in loop
        ]
        way = data.add("EDGE_LOOP", "''", many(runs))
        bounds.append(data.add("FACE_BOUND" if i else "FACE_OUTER_BOUND", "''", way, ".T."))
    surface = face.surface.told(data)
    return data.add("ADVANCED_FACE", "''", many(bounds), surface, _flag(face.outwards))


def _flag(value: bool) -> str:
    return ".T." if value else ".F."
