"""What all followers with a roller have in common: the roller, and what keeps it on its cam."""

from __future__ import annotations

from abc import ABC
from typing import Self

from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.closures.base import Closure


class RollerFollower(Follower, ABC):
    """A follower with a roller; its closure says which curves the cam is made of."""

    roller_radius_mm: float
    closure: Closure

    @property
    def roller_radius(self) -> float:
        return self.roller_radius_mm

    @property
    def active_closure(self) -> Closure:
        return self.closure

    def with_closure(self, closure: Closure) -> Self:
        same = closure is self.closure or closure == self.closure
        return self if same else self.model_copy(update={"closure": closure})
