"""Follower families: one file each. A new one is a file and its name in ``AnyFollower``."""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.followers.base import Follower
from synthesis.followers.oscillating_flat_face import OscillatingFlatFace
from synthesis.followers.oscillating_roller import OscillatingRoller
from synthesis.followers.translating_flat_face import TranslatingFlatFace
from synthesis.followers.translating_roller import TranslatingRoller

AnyFollower = Annotated[
    TranslatingRoller | TranslatingFlatFace | OscillatingRoller | OscillatingFlatFace,
    Field(discriminator="kind"),
]

FOLLOWERS: tuple[type[Follower], ...] = get_args(get_args(AnyFollower)[0])
"""The same as a tuple, in that order."""

__all__ = [
    "FOLLOWERS",
    "AnyFollower",
    "Follower",
    "OscillatingFlatFace",
    "OscillatingRoller",
    "TranslatingFlatFace",
    "TranslatingRoller",
]
