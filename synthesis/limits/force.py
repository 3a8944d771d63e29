"""What the limits on forces have in common: a load, and smooth forms in it."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.followers.base import Follower
from synthesis.followers.flank import Flank
from synthesis.followers.trace import Trace, leaning
from synthesis.forces import Load, Reduced
from synthesis.limits.base import Limit, Machine
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array

SMALL = 1e-300


class ForceLimit(Limit, ABC):
    """A limit on a force: silent without a load, which a spec with such a limit must have."""

    of_forces: ClassVar[bool] = True

    def check_load(
        self, load: Load | None, follower: Follower, stretches: Sequence[Stretch], position: int
    ) -> None:
        if load is None:
            raise PydanticCustomError(
                "limit_needs_load",
                "limits/{position} is {limit}, but nothing is told of what loads the follower. "
                "Give load, or remove the limit.",
                {"position": position, "limit": self.kind},
            )


def loaded(machine: Machine) -> Reduced:
    """The load, which was checked to be there."""
    assert machine.load is not None
    return machine.load


def drive(stretch: Stretch, machine: Machine, theta: Array, s: Any) -> Any:
    """G [N] on a stretch, from columns of s to s''' that may be symbols."""
    load = loaded(machine)
    a, b, c, _ = load.coefficients(machine.omega)
    angles = np.asarray(theta, dtype=float)
    process = load.process_on(stretch, angles.ravel()).reshape(angles.shape)
    # as a column where θ is one, or symbols would see a row
    return a * s[0] + b * s[1] + c * s[2] + (0.0 * theta + (process + load.constant))


def pushing(flank: Flank, machine: Machine) -> int:
    """+1 where the flank pushes the follower the way s grows, or did if it lay inside; else −1."""
    return -1 if flank.path in machine.follower.companions else 1


def yielding(path: Trace, stretch: Stretch, machine: Machine, s: Any, z: Any) -> Any:
    """λ cos α less what friction takes: G = N times this."""
    load = loaded(machine)
    sine, cosine = leaning(path, s, z)
    resisted = load.resisted(load.sliding(stretch), sine, s[0], _absolute)
    return cosine * path.lever(s, z) - resisted


def _absolute(value: Any) -> Any:
    """|·| with a slope that is finite at 0, for numbers and for symbols."""
    return (value * value + 1e-18) ** 0.5
