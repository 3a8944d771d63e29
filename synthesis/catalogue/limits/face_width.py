"""Flat face: contact stays on it."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraints
from synthesis.catalogue.followers.base import Follower, flat_face
from synthesis.catalogue.limits.base import Claim, Limit, Machine, scaling
from synthesis.catalogue.motion import PlacedSegment, Segments

Width = Annotated[float, Field(gt=0.0, le=1e9)]
ENDS = ("left", "right", "near", "far")


class FaceWidth(Limit):
    """Contact stays on the face: on a slide, so far to both sides of the slide's line.

    Left and right are those of an upward follower on a ccw cam, on a cw cam they are exchanged:
    contact moves to the right on rises. A face that swings begins and ends at so much from the foot
    of its pivot on it.

    Note:
        It is linear in the motion and the size.
    """

    kind: Literal["face_width"] = "face_width"
    title: ClassVar[str] = "Width of a flat face"
    bounds_size_below: ClassVar[bool] = True
    width_mm: Width | None = Field(None, description="Width of a face centred on its slide.")
    left_mm: Width | None = Field(None, description="Reach to the left on a ccw cam.")
    right_mm: Width | None = Field(None, description="Reach to the right on a ccw cam.")
    near_mm: Width | None = Field(None, description="Where a face on a pivot begins.")
    far_mm: Width | None = Field(None, description="Where a face on a pivot ends.")

    @model_validator(mode="after")
    def _says_something(self) -> FaceWidth:
        if not self._ends():
            raise PydanticCustomError(
                "face_width_empty",
                "face_width gives no width. Give width_mm, or left_mm and right_mm; near_mm and "
                "far_mm of a face on a pivot.",
            )
        if self.near_mm is not None and self.far_mm is not None and self.near_mm >= self.far_mm:
            raise PydanticCustomError(
                "face_ends_crossed",
                "near_mm = {near} is not below far_mm = {far}: the face has no extent. "
                "Exchange the two.",
                {"near": self.near_mm, "far": self.far_mm},
            )
        return self

    def applies_to(self, follower: Follower) -> bool:
        face = flat_face(follower)
        return face is not None and {end for end, *_ in self._ends()} <= set(face.face_ends)

    def _ends(self) -> list[tuple[str, float, str]]:
        """The ends that are given: name, reach [mm], and what the certificate calls the bound."""
        half = None if self.width_mm is None else 0.5 * self.width_mm
        sides = [("left", half, "face_width"), ("right", half, "face_width")]
        own = ((end, getattr(self, f"{end}_mm"), f"face_{end}") for end in ENDS)
        return [(end, reach, name) for end, reach, name in (*sides, *own) if reach is not None]

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        face = flat_face(machine.follower)
        assert face is not None
        return tuple(
            replace(row, source=name)
            for end, reach, name in self._ends()
            for row in face.contact_rows(end, reach)
        )

    def nonconvex(self, segment: PlacedSegment, machine: Machine) -> NonconvexConstraints:
        face = flat_face(machine.follower)
        assert face is not None
        return tuple(
            replace(constraint, source=name)
            for end, reach, name in self._ends()
            for constraint in face.contact_constraints(end, reach)
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        found = list[Claim]()
        for end, reach, name in self._ends():
            # left counts the other way; near is where the face begins
            quantity = "contact_left" if end == "left" else "contact"
            bounds = (reach, None) if end == "near" else (None, reach)
            if name != "face_width":
                found.append(
                    self._claim(segments, bounds, f"{end}_mm", "mm", name=name, quantity=quantity)
                )
            elif end == "left":  # one claim for both ends
                found.append(
                    self._claim(
                        segments, (-reach, reach), "width_mm", "mm",
                        quantity="contact", to_wire=scaling(2.0),
                    )
                )  # fmt: skip
        return tuple(found)
