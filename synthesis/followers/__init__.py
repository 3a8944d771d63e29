"""Follower families: one file each. A new one is a file and its name in ``AnyFollower``."""

from __future__ import annotations

from synthesis.followers.base import Follower
from synthesis.followers.translating_roller import TranslatingRoller

AnyFollower = TranslatingRoller

FOLLOWERS: tuple[type[Follower], ...] = (TranslatingRoller,)

__all__ = ["FOLLOWERS", "AnyFollower", "Follower", "TranslatingRoller"]
