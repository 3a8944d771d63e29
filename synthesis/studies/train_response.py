"""respond(spec) -> TrainResponse: design the cam by the ordinary pipeline, then drive a train."""

from __future__ import annotations

from synthesis.errors import InputError
from synthesis.machines.dynamics.report import TrainResponse, report_response
from synthesis.machines.dynamics.train import TrainSpec
from synthesis.pipeline.synthesise import synthesise


def respond(spec: TrainSpec, *, deadline: float | None = None) -> TrainResponse:
    """The response of an elastic train to a cam; what the cam leaves free is designed first.

    ``deadline`` is a ``time.monotonic()``; the cam's own budget counts as well.

    Raises:
        InputError: no cam keeps its limits, so that there is no motion.
        TimeBudgetExceeded, SolverFailed: as for the design of the cam.
    """
    design = synthesise(spec.cam, deadline=deadline)
    if not design.motion:
        raise InputError(
            "/cam", spec.cam.name, "No cam keeps these limits, so that there is no motion.",
            "POST it to /v1/designs: conflict says which limits contradict and what would help.",
        )  # fmt: skip
    return report_response(spec, design)
