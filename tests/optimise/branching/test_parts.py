"""Parts of the domain under a cap on a mean square, where every bound is a cone program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.numerics import clock
from synthesis.optimise.propagation.half_spaces import HalfSpaces
from synthesis.optimise.propagation.improving_region import ImprovingRegion
from tests.hard.families import random_scene


@pytest.mark.parametrize(("number", "tolerance", "programs"), [(7, 0.005, 170), (8, 0.02, 155)])
def test_a_face_with_its_pivot_in_a_range_and_no_objective(
    number: int, tolerance: float, programs: int
) -> None:
    # 7: the law of the rise has no spline under the capped value, nor under a raised cap while the
    # region ends there. 8: a better cam is found in a small part alone. Without a time budget it
    # is counted what a proof takes, so that the answer is the same on every machine.
    scene = random_scene("no objective, swinging face, pivot in a range", number)
    body = {**scene, "proof": "thorough", "tolerance": tolerance}
    before = clock.programs_solved()
    design = synthesise(DesignSpec.model_validate(body))
    assert design.status == "optimal"
    assert clock.programs_solved() - before < programs


def test_meshes_that_gain_little_go_on_where_the_jerk_is_capped() -> None:
    # Bounds are linear programs there, and knots cheaper than boxes: ended early, 0.54 % are left.
    scene = random_scene("slide, contact force", 0)
    assert synthesise(DesignSpec.model_validate(scene)).status == "optimal"


def test_a_region_that_is_widened_holds_all_that_is_near_it() -> None:
    rng = np.random.default_rng(7)
    middle = np.array([0.8, 1.5])
    normals = rng.normal(size=(12, 2)) * rng.uniform(0.2, 30.0, (12, 1))
    far = np.linalg.norm(normals, axis=1) * rng.uniform(0.05, 0.15, 12)
    planes = HalfSpaces(normals, normals @ middle - far)
    region = ImprovingRegion(((0.7, 0.9), (1.3, 1.7)), {}, planes)
    wide, points = region.widened(0.02), middle + rng.uniform(-0.2, 0.2, (4000, 2))

    def held(one: ImprovingRegion, z: np.ndarray) -> np.ndarray:
        low, high = np.array(one.sizes).T
        planes = one.half_spaces
        return np.all((z >= low) & (z <= high), 1) & np.all(
            z @ planes.normals.T >= planes.offsets - 1e-12, 1
        )

    inside = points[held(region, points)]
    assert len(inside) > 20
    assert np.all(held(wide, inside + rng.uniform(-0.02, 0.02, inside.shape)))
    assert not np.all(held(wide, inside + rng.uniform(-0.05, 0.05, inside.shape)))
    # what was found in it holds of the region itself, whose sizes come back
    tighter = replace(wide, sizes=((0.69, 0.8), (1.4, 1.71)))
    assert tighter.within(region).sizes == ((0.7, 0.8), (1.4, 1.7))
    assert tighter.within(region).half_spaces is region.half_spaces
    # a size that is known stays known
    known = replace(region, sizes=((0.7, 0.7), (1.3, 1.7)), half_spaces=HalfSpaces.empty(2))
    assert known.widened(0.02).sizes[0] == (0.7, 0.7)
