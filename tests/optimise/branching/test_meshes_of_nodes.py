"""Where the splines of a node hold no better cam, knots alone keep its bound low."""

from synthesis import DesignSpec, synthesise
from tests.hard.families import random_scene


def test_finer_meshes_close_what_no_division_would():
    scene = random_scene("slide, residual vibration", 6)
    design = synthesise(DesignSpec.model_validate(scene))
    assert design.status == "optimal"
    assert design.report.stages[-1].nodes == 1
    # with six meshes, each costly interval halved once on each, 21 boxes did not
