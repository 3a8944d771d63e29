"""The closed shell of a body: faces on its true surfaces, each edge between two of them.

At the ribs' tops and at the floor, the turned surface is divided into regions by the walls' edges
and the blank's ends. Between the two levels are the walls and, at the blank's ends, sections of
ribs. A hub closes the shell.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from synthesis.exporters.curves.step import Entities, many
from synthesis.machines.spatial.solid.geometry import Curve, Surface, point
from synthesis.machines.spatial.solid.sheets import NotSmooth
from synthesis.numerics.piecewise import Array

Key = tuple[object, ...]
Run = tuple[Key, bool]  # an edge, and whether it is traversed in its own direction
SHARES = np.linspace(0.0, 1.0, 33)[:-1]  # of an edge, whose points give a loop's area
FLAG = {True: ".T.", False: ".F."}


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge between two vertices."""

    first: Key
    last: Key
    curve: Curve


@dataclass(frozen=True, eq=False)
class Face:
    """A part of a surface.

    Attributes:
        loops: the outer one first. outwards: whether the surface's normal points out of the body.
    """

    surface: Surface
    loops: list[list[Run]]
    outwards: bool


@dataclass(frozen=True, eq=False)
class Shell:
    """Vertices (3,), edges and faces by key."""

    vertices: dict[Key, Array] = field(default_factory=dict)
    edges: dict[Key, Edge] = field(default_factory=dict)
    faces: list[Face] = field(default_factory=list)

    def join(self, key: Key, first: Key, last: Key, curve: Curve) -> Key:
        """An edge; made at its first use."""
        if key not in self.edges:
            self.edges[key] = Edge(first, last, curve)
            for vertex, share in ((first, 0.0), (last, 1.0)):
                self.vertices.setdefault(vertex, curve.points(np.array([share]))[0])
        return key

    def ends(self, key: Key) -> tuple[Key, Key]:
        """An edge's vertices."""
        return self.edges[key].first, self.edges[key].last

    def add(self, surface: Surface, edges: Iterable[Key], place: Array, out: Array,
            holes: Iterable[Iterable[Key]] = ()) -> None:  # fmt: skip
        """Add a face from edges in any order, oriented counter-clockwise seen from outside.

        Args:
            place, out: (3,) a point of the face, and a direction out of the body there.
        """
        normal = surface.normal(place)
        ahead = float(normal @ out)
        loops = [self._oriented(self.chained(edges), out)]
        loops += [self._oriented(self.chained(each), -out) for each in holes]
        self.faces.append(Face(surface, loops, ahead > 0.0))

    def chained(self, edges: Iterable[Key]) -> list[Run]:
        """The edges as one closed loop."""
        left = list(edges)
        at = left.pop(0)
        loop: list[Run] = [(at, True)]
        start, end = self.edges[at].first, self.edges[at].last
        while left:
            for key in left:
                edge = self.edges[key]
                if end in (edge.first, edge.last):
                    along = edge.first == end
                    end = edge.last if along else edge.first
                    loop.append((key, along))
                    left.remove(key)
                    break
            else:
                raise NotSmooth("edges of a face do not meet")
        if start != end:
            raise NotSmooth("edges of a face do not close")
        return loop

    def _oriented(self, loop: list[Run], out: Array) -> list[Run]:
        points = np.concatenate([self._sampled(*run) for run in loop])
        points = points - np.mean(points, axis=0)
        area = np.sum(np.cross(points, np.roll(points, -1, axis=0)), axis=0)
        if area @ out >= 0.0:
            return loop
        return [(key, not along) for key, along in reversed(loop)]

    def _sampled(self, key: Key, along: bool) -> Array:
        return self.edges[key].curve.points(SHARES if along else 1.0 - SHARES)

    def check(self) -> None:
        """Check that every edge is traversed once in each direction.

        Raises:
            NotSmooth: the shell is not closed.
        """
        runs = [run for face in self.faces for loop in face.loops for run in loop]
        if len(set(runs)) != len(runs) or len(runs) != 2 * len(self.edges):
            raise NotSmooth("the shell is not closed")

    def to_step(self, data: Entities) -> str:
        """Write the CLOSED_SHELL with all its entities; returns the reference."""
        corners = {
            key: data.add("VERTEX_POINT", "''", point(data, place))
            for key, place in self.vertices.items()
        }
        edges = {
            key: data.add("EDGE_CURVE", "''", corners[edge.first], corners[edge.last],
                          edge.curve.to_step(data), ".T.")
            for key, edge in self.edges.items()
        }  # fmt: skip
        faces = []
        for face in self.faces:
            bounds = []
            for i, loop in enumerate(face.loops):
                runs = [data.add("ORIENTED_EDGE", "''", "*", "*", edges[key], FLAG[along])
                        for key, along in loop]  # fmt: skip
                ring = data.add("EDGE_LOOP", "''", many(runs))
                kind = "FACE_BOUND" if i else "FACE_OUTER_BOUND"
                bounds.append(data.add(kind, "''", ring, ".T."))
            surface, sense = face.surface.to_step(data), FLAG[face.outwards]
            faces.append(data.add("ADVANCED_FACE", "''", many(bounds), surface, sense))
        return data.add("CLOSED_SHELL", "''", many(faces))
