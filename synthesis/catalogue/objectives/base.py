"""The base of every objective: the forms that the optimiser reads, and its value on the wire."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, Vector
from synthesis.catalogue.fields import FiniteModel
from synthesis.catalogue.limits.base import Limit, Machine
from synthesis.catalogue.motion import PlacedSegment, Segments


class Objective(FiniteModel, ABC):
    """One quantity to minimise. It is stated in one of three forms; the other two are empty.

    The forms: ``norm`` of the size, ``energy_order`` for a mean square, ``rows`` with the epigraph
    variable P.

    Attributes:
        title: for people.
        quantity: what ``certify`` measures, in core units (mm, per radian, tan α).
        wire_name: name of its value on the wire, with the unit; see ``name_on_wire``.
        quasiconvex: its rows hold for one trial ``level`` at a time (quasi-convex).
    """

    kind: str
    title: ClassVar[str]
    quantity: ClassVar[str]
    wire_name: ClassVar[str]
    quasiconvex: ClassVar[bool] = False

    def check_load(self, segments: Segments, machine: Machine, position: int) -> None:
        """Refuse an objective about forces for which the load is missing or incomplete."""
        return None

    def norm(self, machine: Machine) -> AffineNorm | None:
        """The value as a norm of the size variables."""
        return None

    def energy_order(self) -> int | None:
        """k where the value is the rms over the turn of the k-th derivative."""
        return None

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        """Rows in which P is an upper bound of the value.

        Args:
            segment: where. machine: the machine.
            level: trial value, only of use where ``quasiconvex``: there the rows bound by P how
                much the trial level is exceeded.
        """
        return ()

    def equivalent_limits(self, value: float, machine: Machine) -> tuple[Limit, ...]:
        """Limits that bound the value [core units], where no rows or norms do; () otherwise."""
        return ()

    def segment_value(self, segment: PlacedSegment, machine: Machine, size: Vector) -> float:
        """The value on one segment with a known law, where ``equivalent_limits`` state it."""
        raise NotImplementedError(f"{self.kind} is not measured segment by segment")

    def name_on_wire(self, machine: Machine) -> str:
        """Name of its value on the wire, with the unit that such a follower has."""
        return self.wire_name

    @abstractmethod
    def to_wire(self, value: float, machine: Machine) -> float:
        """The value in the wire's unit; monotone, so that it carries bounds as well."""

    @abstractmethod
    def from_wire(self, value: float, machine: Machine) -> float:
        """The inverse of ``to_wire``."""
