"""What all followers with a roller have in common: the roller, and what keeps it on its cam."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping
from typing import Self

from synthesis.followers.base import Follower
from synthesis.followers.closures.base import Closure
from synthesis.followers.flank import Flank, Places
from synthesis.ranges import Range


class RollerFollower(Follower, ABC):
    """A follower with a roller; its closure says which curves the cam is made of."""

    roller_radius_mm: float
    closure: Closure

    @property
    def roller_radius(self) -> float:
        return self.roller_radius_mm

    @property
    def flanks(self) -> tuple[Flank, ...]:
        return self.closure.flanks(self, self.roller_radius_mm)

    @property
    def companions(self) -> tuple[str, ...]:
        return self.closure.companions

    def companion_ranges(self) -> Mapping[str, tuple[str, float | Range | None]]:
        return self.closure.companion_ranges()

    def places(self, z: tuple[float, ...], s_max: float) -> Places:
        return self.closure.places(self, z, s_max)

    def opened(self) -> Self:
        return self._closed(self.closure.opened())

    def alone(self) -> Self:
        return self._closed(self.closure.alone())

    def companion(self, values: Mapping[str, float]) -> Self:
        return self._closed(self.closure.companion(values))

    def completed(self, values: Mapping[str, float]) -> Self:
        return self._closed(self.closure.completed(values))

    def _closed(self, closure: Closure) -> Self:
        same = closure is self.closure or closure == self.closure
        return self if same else self.model_copy(update={"closure": closure})
