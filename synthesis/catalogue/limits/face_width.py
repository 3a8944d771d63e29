"""Flat face: contact stays on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraint
from synthesis.catalogue.followers.base import FlatFaceFollower, Follower, flat_face
from synthesis.catalogue.limits.base import Claim, Limit, Machine, scaling
from synthesis.catalogue.motion import PlacedSegment, Segments

Width = Annotated[float, Field(gt=0.0, le=1e9)]


class FaceWidth(Limit):
    """Contact stays on the face: on a slide, so far to both sides of the slide's line.

    Left and right are those of an upward follower on a ccw cam, on a cw cam they are exchanged:
    contact moves to the right on rises. It is linear in the motion and the size. A face that
    swings begins and ends at so much from the foot of its pivot on it.
    """

    kind: Literal["face_width"] = "face_width"
    title: ClassVar[str] = "Width of a flat face"
    width_mm: Width | None = Field(None, description="Width of a face centred on its slide.")
    left_mm: Width | None = Field(None, description="Reach to the left on a ccw cam.")
    right_mm: Width | None = Field(None, description="Reach to the right on a ccw cam.")
    near_mm: Width | None = Field(None, description="Where a face on a pivot begins.")
    far_mm: Width | None = Field(None, description="Where a face on a pivot ends.")

    @model_validator(mode="after")
    def _says_something(self) -> FaceWidth:
        if self.width_mm is None and not self._ends():
            raise PydanticCustomError(
                "face_width_empty",
                "face_width gives no width. Give width_mm, or left_mm and right_mm; near_mm and "
                "far_mm of a face on a pivot.",
                {},
            )
        if self.near_mm is not None and self.far_mm is not None and self.near_mm >= self.far_mm:
            raise PydanticCustomError(
                "face_ends_crossed",
                "near_mm = {near} is not below far_mm = {far}: the face has no extent. "
                "Exchange the two.",
                {"near": self.near_mm, "far": self.far_mm},
            )
        return self

    @property
    def bounds_size_below(self) -> bool:
        return True

    def applies_to(self, follower: Follower) -> bool:
        named = [end for end, _ in self._ends()]
        face = flat_face(follower)
        known = () if face is None else face.face_ends
        return (self.width_mm is None or "left" in known) and set(named) <= set(known)

    def _ends(self) -> list[tuple[str, float]]:
        """The ends that are given, by name."""
        given = [(end, getattr(self, f"{end}_mm")) for end in ("left", "right", "near", "far")]
        return [(end, reach) for end, reach in given if reach is not None]

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        face = flat_face(machine.follower)
        return () if face is None else tuple(self._rows(face))

    def _rows(self, face: FlatFaceFollower) -> Iterator[LinearInequality]:
        if self.width_mm is not None:
            for row in face.contact_rows(0.5 * self.width_mm, 0.5 * self.width_mm):
                yield replace(row, source="face_width")
        for end, reach in self._ends():
            rows = zip(face.face_ends, face.contact_rows(reach, reach), strict=False)
            yield from (replace(row, source=f"face_{end}") for name, row in rows if name == end)

    def nonconvex(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[NonconvexConstraint, ...]:
        face = flat_face(machine.follower)
        if face is None:
            return ()
        return tuple(
            replace(constraint, source=f"face_{end}")
            for end, reach in self._ends()
            for constraint in face.contact_constraints(end, reach)
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        found = list[Claim]()
        if self.width_mm is not None:
            half, field = 0.5 * self.width_mm, "width_mm"
            found.append(
                self._claim(
                    segments, (-half, half), field, "mm", quantity="contact", to_wire=scaling(2.0)
                )
            )
        for end, reach in self._ends():
            # left counts the other way; near is where the face begins
            quantity = "contact_left" if end == "left" else "contact"
            bounds = (reach, None) if end == "near" else (None, reach)
            found.append(
                self._claim(
                    segments, bounds, f"{end}_mm", "mm", name=f"face_{end}", quantity=quantity
                )
            )
        return tuple(found)
