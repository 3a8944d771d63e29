"""What every machine around a spatial cam promises."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic_core import PydanticCustomError

from synthesis.geometry.charts import Chart
from synthesis.geometry.swept_roller import SweptRoller
from synthesis.ranges import Range, ends
from synthesis.spatial.leverage import Leverage
from synthesis.terms import Row
from synthesis.units import Travel

LEFT, RIGHT = -1, 1
LARGEST = 1e6  # mm


@dataclass(frozen=True)
class Seat:
    """One roller of the follower.

    Attributes:
        number: as it is named, from 1. start: what is added to the motion's q [rad or mm].
        sides: of the roller that run on the cam, +1 the one in the direction of growing q.
    """

    number: int
    start: float
    sides: tuple[int, ...] = (LEFT, RIGHT)


class SpatialMachine(BaseModel, ABC):
    """A follower with one roller or several, and where it stands against the cam."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    travel: ClassVar[Travel]
    period: ClassVar[float] = math.inf  # of q, after which a roller is where it was [rad or mm]
    sought: ClassVar[str] = ""  # field of the dimension that is made small; empty: none yet
    roller_field: ClassVar[str] = "roller_radius_mm"
    place_field: ClassVar[str] = ""  # of the rollers' inner end on a turret; empty: none
    unrolls: ClassVar[bool] = False  # whether cylinders about its axis cut the cam's walls

    @model_validator(mode="after")
    def _sized(self) -> Self:
        for name, given in self.sizes().items():
            low, high = ends(given)
            if high <= 0.0 or (low == high and low > LARGEST):
                raise PydanticCustomError(
                    "no_such_size",
                    "{name} is {given}, and no machine has that. Give a length above 0 and not "
                    "above {largest} mm.",
                    {"name": name, "given": high, "largest": LARGEST},
                )
        return self

    @abstractmethod
    def sizes(self) -> Mapping[str, float | Range | None]:
        """Dimensions that may be left free, by their field's name [mm]."""

    @abstractmethod
    def swept(self, sizes: Mapping[str, float], turns: int) -> SweptRoller:
        """The machine with its dimensions settled.

        Args:
            sizes: a number for each of ``sizes()`` [mm].
            turns: +1 where the cam turns ccw, −1 where it turns cw.
        """

    def dimensions(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        """What an answer tells of a machine with these dimensions, ``sizes`` among them [mm]."""
        return sizes

    def rooms(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        """Lengths that have to be there besides the walls, by name: above 0 [mm]."""
        return {}

    @abstractmethod
    def seats(self) -> tuple[Seat, ...]:
        """The rollers that can meet the cam during one turn of it."""

    @abstractmethod
    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        """Least and largest place q of a roller [rad or mm] where the blank still has a wall."""

    def faces(self) -> tuple[float, float]:
        """Places of the cam's end faces along its axis, from its centre [mm]; open if infinite."""
        return -math.inf, math.inf

    def cylinder(self, sizes: Mapping[str, float]) -> tuple[float, float] | None:
        """Radii between which cylinders cut its cam's walls [mm]; None: it does not unroll."""
        return None

    @abstractmethod
    def chart(self, sizes: Mapping[str, float]) -> Chart:
        """Coordinates that suit its cam's blank."""

    @abstractmethod
    def check_gain(self, gain: float) -> None:
        """Refuse a program that moves the follower by ``gain`` in a turn [rad or mm].

        Raises:
            PydanticCustomError: the next turn would not find a roller where this one ended.
        """

    def check_reach(self, lowest: float, highest: float) -> None:
        """Refuse a program that brings the follower where it cannot be [rad or mm]."""
        return None

    # -- what is asked where the dimension ``sought`` is made small ------------------------------

    @property
    def sizable(self) -> bool:
        """Whether something may be left free."""
        return bool(self.sought)

    def rest_rib(self, sizes: Mapping[str, float]) -> float:
        """Thickness of the thinnest rib where the follower rests; infinite where it has none [mm].

        ``sizes``: the radius of the rollers, and their place where it is one of them.
        """
        return math.inf

    def reach(self, sizes: Mapping[str, float]) -> float:
        """A length for one unit of q, near that of the rollers' travel [mm]."""
        return 1.0

    def pressure_angle_rows(self, sizes: Mapping[str, float], slope: float) -> tuple[Row, ...]:
        """|tan α| ≤ slope, where it is linear in the motion and the dimension sought.

        Args:
            sizes: the other dimensions [mm]. slope: tan α_max.
        """
        return ()

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, turns: int
    ) -> tuple[Leverage, ...]:
        """The same where it is not linear, the motion being ``reach`` times q.

        Args:
            turns: +1 where the cam turns ccw, −1 where it turns cw.
        """
        return ()

    def wall_curves(self, sizes: Mapping[str, float], least: float) -> tuple[Leverage, ...]:
        """Convex radius of walls ≥ least [mm], 0 where they are not undercut; () where no form of
        it is known: then cams grow until it is kept.
        """
        return ()
