"""Sweeps: many designs out of one, their trade-offs. Nothing is solved here."""

from __future__ import annotations

from synthesis.sweeps.spec import SweepSpec

__all__ = ["SweepSpec"]
