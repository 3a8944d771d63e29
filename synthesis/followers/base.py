"""What every follower family promises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict

from synthesis.terms import Cone, Norm, Row

Vector2 = tuple[Any, Any]


@dataclass(frozen=True)
class Sizing:
    """Where the size variables may lie.

    Attributes:
        bounds: (lower, upper) of every size variable, finite [mm].
        cones: what else is convex.
        least: smallest prime radius [mm]; not convex, so bounds and cones say only part of it.
    """

    bounds: tuple[tuple[float, float], ...]
    cones: tuple[Cone, ...]
    least: float


class Follower(BaseModel, ABC):
    """A follower family: given dimensions, free dimensions (the size z), and its geometry.

    Symbols: s to s''' displacement and derivatives per radian [mm]; z size variables [mm];
    Rp prime radius. Vectors are in the machine frame: origin on the cam's axis, y along an
    upward follower, the cam turning counter-clockwise (a clockwise cam is the mirror image).
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    size_names: ClassVar[tuple[str, ...]]

    @property
    @abstractmethod
    def roller_radius(self) -> float:
        """Distance of the profile from the curve of the traced point [mm]; 0 at a knife edge."""

    @abstractmethod
    def sizing(self, base_radius: tuple[float, float]) -> Sizing:
        """Where z may lie for a base radius between two ends [mm]."""

    @abstractmethod
    def prime_radius(self) -> Norm:
        """Rp as a norm of z."""

    @abstractmethod
    def raised(self, z: tuple[float, ...], amount: float) -> tuple[float, ...]:
        """The size made larger by ``amount`` [mm] in the way that eases every geometric limit."""

    @abstractmethod
    def room(
        self, z: tuple[float, ...], bounds: Sequence[tuple[float, float]], cones: Sequence[Cone]
    ) -> float:
        """How far ``raised`` can go within bounds and cones of the size [mm]."""

    @abstractmethod
    def reaching(self, z: tuple[float, ...], radius: float) -> tuple[float, ...]:
        """The size raised until its prime radius is at least ``radius`` [mm]."""

    @abstractmethod
    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        """|tan α| ≤ slope as rows linear in s, s' and z."""

    @abstractmethod
    def traced_point(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        """The roller's centre and its θ-derivatives 1 to 3 in the machine frame.

        Args:
            s: the four values s, s', s'', s''', of any arithmetic type (arrays, intervals).
            z: size variables.

        Returns:
            four pairs (x, y).
        """

    @abstractmethod
    def direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """Unit vector along which the roller's centre is driven, and its θ-derivative."""

    @abstractmethod
    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        """Numerator N and squared speed W² of the traced curve: κ = N / W³, convex positive."""

    @abstractmethod
    def outermost(self, s_max: float) -> Norm:
        """Largest radius of the traced curve, at displacement ``s_max``, as a norm of z."""

    @abstractmethod
    def dimensions(self, z: tuple[float, ...]) -> Mapping[str, float]:
        """The cam's dimensions as named on the wire [mm]."""
