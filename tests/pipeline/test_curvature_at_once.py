"""A cam that curvature decides is found, and certified, in one go."""

from benchmarks.proof import SCENES
from synthesis import synthesise


def test_no_round_for_an_idle_bound_and_no_second_attempt() -> None:
    (scene,) = (scene for scene in SCENES if scene.name == "small lift")
    design = synthesise(scene.spec())
    assert [stage.stage for stage in design.report.stages] == ["convex 1", "nonlinear"]
    assert all(extreme.holds for extreme in design.extremes)
    # as small as with the second round: its knots are taken, its bound is not waited for
    assert design.dimensions["prime_radius_mm"] < 36.4525
