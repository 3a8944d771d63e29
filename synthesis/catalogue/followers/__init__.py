"""Follower families, one a file. A new one is a file and its name in ``AnyFollower``.

A family is a bare mechanism: the curve that its trace point draws on the cam, and the size
variables z that fix the cam. Open ``base`` first, then ``kinematics``; ``translating_roller`` is
the shortest family with a roller, ``translating_flat_face`` the shortest with a face. Beside them
lie the constraints that are not linear (``arm_pressure_angle``, ``swinging_face``,
``curvature_bound``) and what keeps a roller on its cam (``closures``).
"""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.oscillating_flat_face import OscillatingFlatFace
from synthesis.catalogue.followers.oscillating_roller import OscillatingRoller
from synthesis.catalogue.followers.translating_flat_face import TranslatingFlatFace
from synthesis.catalogue.followers.translating_roller import TranslatingRoller

AnyFollower = Annotated[
    TranslatingRoller | TranslatingFlatFace | OscillatingRoller | OscillatingFlatFace,
    Field(discriminator="kind"),
]

FOLLOWERS: tuple[type[Follower], ...] = get_args(get_args(AnyFollower)[0])
"""The same as a tuple, in that order."""

__all__ = ["FOLLOWERS", "AnyFollower", "Follower"]
