"""respond(spec) -> TrainResponse: a cam by the ordinary pipeline, then a train on it."""

from __future__ import annotations

from synthesis.dynamics.report import TrainResponse
from synthesis.dynamics.summary import summed_up
from synthesis.dynamics.train import TrainSpec
from synthesis.errors import InputError
from synthesis.pipeline import synthesise


def respond(spec: TrainSpec, *, deadline: float | None = None) -> TrainResponse:
    """What an elastic train does on a cam; what the cam leaves free is designed first.

    ``deadline`` is a ``time.monotonic()``; the cam's own budget counts as well.

    Raises:
        InputError: nothing fits the cam's limits, so that there is no motion.
        TimeBudgetExceeded, SolverFailed: as for the design of the cam.
    """
    design = synthesise(spec.cam, deadline=deadline)
    if not design.motion:
        raise InputError(
            "/cam", spec.cam.name, "No cam fits these limits, so there is no motion to respond to.",
            "POST it to /v1/designs: conflict says which limits clash and what would help.",
        )  # fmt: skip
    return summed_up(spec, design)
