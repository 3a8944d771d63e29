"""What an answer says of what was assumed where the spec says nothing."""

from __future__ import annotations

from synthesis.spec.design_spec import DesignSpec


def assumptions(spec: DesignSpec) -> list[str]:
    """Sentences: what was assumed, and how to ask otherwise."""
    return [sentence for sentence in [_objective(spec)] if sentence]


def _objective(spec: DesignSpec) -> str:
    """Which objective was assumed; empty where one is named, and where it is the size alone."""
    first, *later = spec.objectives()
    if spec.objective is not None or not later:
        return ""
    chosen = ""
    if spec.free_parameters.machine_indices:
        chosen = " The numbers left free are those of the smallest cam."
    elif spec.free_parameters.parameters:
        chosen = " The angles and lifts left free are those of the least rms jerk."
    return (
        "Nothing is said of acceleration or jerk: rms jerk may be "
        f"{100.0 * (first.allowance or 0.0):g} % above the least possible, and the base radius is "
        f"the smallest that this allows.{chosen} To ask otherwise, limit acceleration or jerk, or "
        'name an objective: {"kind": "base_radius"} is the smallest cam, however rough its motion.'
    )
