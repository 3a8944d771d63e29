"""Fields that several bodies of the wire share: what a thing is called, how its shaft turns."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Name = Annotated[str, Field(max_length=200)]
"""What a person calls a cam or a set of cams."""

Speed = Annotated[float, Field(ge=1e-6, le=1e9)]
"""Constant speed of a cam or its shaft [rpm]."""

Rotation = Literal["ccw", "cw"]
"""Sense of turning, seen with the cam's axis towards the viewer."""

CamSpeed = Annotated[Speed, Field(description="Cam speed, constant over the turn [rpm].")]
CamRotation = Annotated[Rotation, Field(description="Sense in which the cam turns.")]


class AnswerModel(BaseModel):
    """A part of an answer: frozen, and without fields that the contract does not name."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class FiniteModel(BaseModel):
    """The same with finite numbers only: requests, and answers without infinities."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def doc(description: str) -> Any:
    """A required field with its description in the contract."""
    return Field(description=description)
