"""What an objective says to the formulations, and how its value is measured and reported."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from pydantic import BaseModel, ConfigDict

from synthesis.followers.base import Follower
from synthesis.forces import Load
from synthesis.limits.base import Limit, Machine
from synthesis.motion import Stretch
from synthesis.terms import Norm, Row


class Objective(BaseModel, ABC):
    """One quantity to make small. It speaks in one of three ways; the other two stay silent.

    Attributes:
        title: for people.
        quantity: what ``certify`` measures, in core units (mm, per radian, tan α).
        wire_name: name of its value on the wire, with the unit; asked for by ``name_on_wire``.
        fractional: its rows hold for one trial ``level`` at a time (quasi-convex).
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: str
    title: ClassVar[str]
    quantity: ClassVar[str]
    wire_name: ClassVar[str]
    fractional: ClassVar[bool] = False

    def check_load(
        self, load: Load | None, follower: Follower, stretches: Sequence[Stretch], position: int
    ) -> None:
        """Refuse an objective about forces that are not told enough of."""
        return None

    def norm(self, machine: Machine) -> Norm | None:
        """The value as a norm of the size variables."""
        return None

    def energy_order(self) -> int | None:
        """k where the value is the rms over the turn of the k-th derivative."""
        return None

    def rows(self, stretch: Stretch, machine: Machine, level: float) -> tuple[Row, ...]:
        """Rows in which P is an upper bound of the value.

        Args:
            stretch: where. machine: the machine.
            level: trial value, only of use where ``fractional``: there the rows bound by P how
                much the trial level is exceeded.
        """
        return ()

    def limits(self, value: float, machine: Machine) -> tuple[Limit, ...]:
        """What limits the value [core units] where no row does; () where rows or norms do."""
        return ()

    def worst(self, stretch: Stretch, machine: Machine, size: tuple[float, ...]) -> float:
        """The value on one settled stretch, where ``limits`` say it."""
        raise NotImplementedError(f"{self.kind} is not measured stretch by stretch")

    def name_on_wire(self, machine: Machine) -> str:
        """Name of its value on the wire, with the unit that such a follower has."""
        return self.wire_name

    @abstractmethod
    def to_wire(self, value: float, machine: Machine) -> float:
        """The value in the wire's unit; monotone, so that it carries bounds as well."""

    @abstractmethod
    def from_wire(self, value: float, machine: Machine) -> float:
        """The inverse of ``to_wire``."""
