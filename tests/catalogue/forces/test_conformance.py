"""What every load and every friction model of the catalogue has to keep."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from synthesis.catalogue.followers import FOLLOWERS
from synthesis.catalogue.forces import AnyLoad
from synthesis.catalogue.forces.friction import AnyFriction, FrictionModel
from tests.catalogue.forces import loads

LOADS = get_args(get_args(AnyLoad)[0])
MODELS: tuple[type[FrictionModel], ...] = get_args(AnyFriction) or (AnyFriction,)
STROKE = 25.0  # mm
FRICTION = {"GuideFriction": {"coefficient": 0.13, "overhang_mm": 60.0, "bearing_length_mm": 80.0}}
"""An example of every friction model, valid up to the stroke."""


def test_every_kind_of_follower_has_its_load() -> None:
    """The loads that the tests of forces use are of every kind, and suit every family."""
    kinds = {load.model_fields["kind"].default for load in LOADS}
    used = {loads.load_of(family.model_fields["kind"].default)["kind"] for family in FOLLOWERS}
    assert kinds <= used, f"add {kinds - used} to tests/catalogue/forces/loads.py"


@pytest.mark.parametrize("model", MODELS)
def test_friction_does_not_grow_with_the_displacement(model: type[FrictionModel]) -> None:
    """Rows and relaxations take its values at the ends of a range as its extremes."""
    assert model.__name__ in FRICTION, f"{model.__name__} has no example in {__file__}"
    friction = model.model_validate(FRICTION[model.__name__])
    friction.check(STROKE)
    share = friction.share_of_side_force(np.linspace(0.0, STROKE, 101))
    assert np.all(share >= 0.0)
    assert np.all(np.diff(share) <= 1e-12 * np.max(share)), f"{model.__name__} grows with s"
