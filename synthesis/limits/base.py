"""What a limit says: rows to the cone program, smooth forms to IPOPT, claims to the judge."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict

from synthesis.followers.base import Follower
from synthesis.forces import Load, Reduced
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Cone, Curved, Implied, Ringing, Row, Traced


@dataclass(frozen=True)
class Machine:
    """What surrounds the motion.

    Attributes:
        follower: the follower's family and given dimensions.
        omega: cam speed ω [rad/s].
        load: what loads the follower, where forces are asked about.
    """

    follower: Follower
    omega: float
    load: Reduced | None = None

    def rate(self, order: int) -> float:
        """Factor from s^(order) per radian to the time derivative in the wire's unit."""
        return self.follower.travel.rate(order, self.omega)

    def told(self, order: int) -> str:
        """That unit."""
        return self.follower.travel.told(order)


@dataclass(frozen=True)
class Claim:
    """What the finished cam must satisfy: lower ≤ quantity ≤ upper on the named stretches.

    Attributes:
        limit: the limit as named in the certificate.
        quantity: a name that ``certify`` knows, measured in core units (rad, mm, per radian).
        stretches: indices of the stretches where it must hold.
        lower, upper: bounds in core units; None where there is none.
        unit: unit on the wire.
        to_wire: monotone map from the core's unit to the wire's; None where the wire has no value.
        field: the field of the spec that sets it, as in ``limits/pressure_angle/rise_deg``.
        path: name of the traced curve that is measured, among the follower's ``paths``.
        part: first and last x, in [0, 1], of these stretches where it must hold; None: all along.
        exact: the quantity has one value there; the bounds leave no more than rounding.
        flank: name of the flank that is measured, where it is not the first.
        rings: what is left where runs of these stretches end; the largest of it is measured.
    """

    limit: str
    quantity: str
    stretches: tuple[int, ...]
    lower: float | None
    upper: float | None
    unit: str
    to_wire: Callable[[float], float | None]
    field: str
    path: str = ""
    part: tuple[float, float] | None = None
    exact: bool = False
    flank: str = ""
    rings: tuple[Ringing, ...] = ()


class Limit(BaseModel, ABC):
    """One thing that may not be exceeded. Saying nothing is an empty tuple."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    of_forces: ClassVar[bool] = False  # it needs to know what loads the follower
    same_everywhere: ClassVar[bool] = False  # its smooth form asks of no stretch what it is

    def suits(self, follower: Follower) -> bool:
        """Whether the limit says anything about such a follower."""
        return True

    @property
    def travel_unit(self) -> str | None:
        """Unit of displacement that it is given in; None where it is not about displacement."""
        return None

    @property
    def keeps_large(self) -> bool:
        """Whether a cam that keeps it cannot be as small as one likes."""
        return False

    @property
    def least_circle(self) -> float:
        """Radius that a circle about the cam's axis must have at least to be a part of it [mm]."""
        return 0.0

    @property
    def said_in_part(self) -> bool:
        """Whether its rows leave something to its smooth form."""
        return False

    @property
    def least_force(self) -> float:
        """Contact force that it leaves at least [N]."""
        return 0.0

    @property
    def steepest(self) -> float:
        """tan of the largest pressure angle that it allows; infinite where it is silent of it."""
        return inf

    def check(self, follower: Follower) -> None:
        """Refuse a value that no cam of such a follower can keep."""
        return None

    def check_load(
        self, load: Load | None, follower: Follower, stretches: Sequence[Stretch], position: int
    ) -> None:
        """Refuse a limit on forces that are not told enough of; ``position``: of the limit."""
        return None

    def check_motion(self, stretches: Sequence[Stretch], machine: Machine) -> None:
        """Refuse a value that makes no sense for such a program at such a speed."""
        return None

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        """Linear rows on one stretch; for a limit that is not convex, those it implies."""
        return ()

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        """What it says on one stretch of motion and size together, where no fixed row does."""
        return ()

    def implied(self, stretch: Stretch, machine: Machine) -> tuple[Implied, ...]:
        """What of its smooth form becomes rows once motion and size are known to lie in a range."""
        return ()

    def traced(self, stretch: Stretch, machine: Machine) -> tuple[Traced, ...]:
        """What of it becomes rows once the points that draw the cam's curves lie in a range."""
        return ()

    def cones(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Cone, ...]:
        """Cones on the size variables."""
        return ()

    def ringing(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Ringing, ...]:
        """What the motion may leave oscillators ringing with."""
        return ()

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        """Dimensionless expressions that must be ≤ 0, where rows and cones do not say it all.

        Args:
            stretch: where. machine: the machine. theta: (n,) cam angles, numbers [rad].
            s: s, s', s'', s''' as NumPy arrays or CasADi columns of one length [mm, per rad].
            z: the size variables, scalars [mm].
        """
        return ()

    def widened(self, amount: float) -> Limit:
        """The limit giving way by an amount [wire]; where its claims are of a part of a stretch."""
        return self

    @abstractmethod
    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        """What the certificate has to show on the finished cam."""


def times(factor: float) -> Callable[[float], float]:
    """The map that multiplies by ``factor``."""
    return lambda value: value * factor


def where(stretches: Sequence[Stretch], *kinds: str) -> tuple[int, ...]:
    """Indices of the stretches that move so and have an extent (of all if nothing is named)."""
    wanted = set(kinds)
    return tuple(
        s.index
        for s in stretches
        if s.angle > 0.0 and (not wanted or not wanted.isdisjoint(s.senses))
    )
