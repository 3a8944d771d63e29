"""What is asked of a sweep: read and checked in a process that reads bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from service.sweeps.tasks import item_spec
from service.wire.errors import ProblemType, ServiceError
from service.wire.validation import validate
from synthesis.studies.sweeps import SweepSpec
from synthesis.studies.sweeps.spec import ListAxis, sweep_id

SAMPLED = 8  # items that are validated before a sweep is accepted: the first, the last, and between


@dataclass(frozen=True)
class SweepQuestion:
    """What the store and lists need of a sweep's spec; ``text`` is the spec with all fields."""

    id: str
    name: str
    size: int
    axes: list[str]
    text: str


def sweep_question(spec: SweepSpec) -> SweepQuestion:
    """The same of a spec that was read already."""
    axes = [axis.pointer for axis in spec.axes]
    return SweepQuestion(sweep_id(spec), spec.name, spec.size, axes, spec.model_dump_json())


def read_sweep(body: bytes, most: int) -> SweepQuestion:
    """Bytes as a sweep of at most so many items.

    Invalid items fail one by one when their turn comes: a corner of a grid may be out of reach.
    Where none of some that lie far apart is valid, the sweep is refused.
    """
    spec = validate(body, SweepSpec)
    if spec.size > most:
        rule = f"makes {spec.size} items; this server takes {most} in a sweep"
        remedy = "Give fewer values, use a Latin hypercube, or split the sweep in parts."
        wrong = {"pointer": "/axes", "value": spec.size, "rule": rule, "remedy": remedy}
        raise ProblemType.INVALID_REQUEST(f"/axes: {rule}. {remedy}", violations=[wrong])
    step = (spec.size - 1) / (SAMPLED - 1)
    sample = dict.fromkeys(round(i * step) for i in range(SAMPLED))
    first: ServiceError | None = None
    for number in sample:
        try:
            item_spec(spec, spec.item_values(number))
        except ServiceError as error:
            first = first or error
        else:
            return sweep_question(spec)
    assert first is not None
    violations = [
        {**each, "pointer": _in_sweep(spec, each["pointer"], each["value"])}
        for each in first.violations
    ]
    raise ProblemType.INVALID_REQUEST(
        f"None of {len(sample)} items that were tried is valid. With the values of item 0: "
        f"{first.detail}", violations=violations,
    )  # fmt: skip


def _in_sweep(spec: SweepSpec, pointer: str, value: Any) -> str:
    """Where in a sweep a wrong value of an item's spec was written: in an axis, or in the base."""
    for number, axis in enumerate(spec.axes):
        if pointer in (axis.pointer, *axis.linked_pointers):
            listed = axis.values if isinstance(axis, ListAxis) else []
            inside = f"/values/{listed.index(value)}" if value in listed else ""
            return f"/axes/{number}{inside}"
    return f"/base{pointer}"
