"""Flat face: contact stays on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.followers.base import Follower
from synthesis.limits.base import Claim, Limit, Machine, times, where
from synthesis.motion import Stretch
from synthesis.terms import Row

Width = Annotated[float, Field(gt=0.0, le=1e9)]


class FaceWidth(Limit):
    """Contact stays on the face, which reaches so far to both sides of the slide's line.

    Left and right are those of an upward follower on a ccw cam, on a cw cam they are exchanged:
    contact is to the right on rises. Contact at s': linear in the motion, free of the size.
    """

    kind: Literal["face_width"] = "face_width"
    title: ClassVar[str] = "Width of a flat face"
    width_mm: Width | None = Field(None, description="Width of a face centred on its slide.")
    left_mm: Width | None = Field(None, description="Reach to the left on a ccw cam.")
    right_mm: Width | None = Field(None, description="Reach to the right on a ccw cam.")

    @model_validator(mode="after")
    def _says_something(self) -> FaceWidth:
        if self.width_mm is None and self.left_mm is None and self.right_mm is None:
            raise PydanticCustomError(
                "face_width_empty",
                "face_width gives no width. Give width_mm, or left_mm and right_mm.",
                {},
            )
        return self

    def suits(self, follower: Follower) -> bool:
        return bool(follower.contact_rows(1.0, 1.0))

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        return tuple(self._rows(machine.follower))

    def _rows(self, follower: Follower) -> Iterator[Row]:
        if self.width_mm is not None:
            for row in follower.contact_rows(0.5 * self.width_mm, 0.5 * self.width_mm):
                yield replace(row, source="face_width")
        for position, (name, reach) in enumerate(self._sides()):
            if reach is not None:
                row = follower.contact_rows(reach, reach)[position]
                yield replace(row, source=f"face_{name}")

    def _sides(self) -> tuple[tuple[str, float | None], ...]:
        return ("left", self.left_mm), ("right", self.right_mm)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        everywhere, found = where(stretches), list[Claim]()
        if self.width_mm is not None:
            half = 0.5 * self.width_mm
            found.append(
                Claim(
                    "face_width", "contact", everywhere, -half, half, "mm", times(2.0),
                    "face_width/width_mm",
                )
            )  # fmt: skip
        for name, reach in self._sides():
            if reach is not None:
                found.append(
                    Claim(
                        f"face_{name}", f"contact_{name}", everywhere, None, reach, "mm",
                        times(1.0), f"face_width/{name}_mm",
                    )
                )  # fmt: skip
        return tuple(found)
