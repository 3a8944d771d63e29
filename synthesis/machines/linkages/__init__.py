"""Linkages: machines of rigid links, analysed or sized.

In: the spec of one kind of linkage. Out: its answer, and files made from it (``files``).
``LINKAGES`` lists the kinds: a new one is a folder and its row here. ``shaper`` is the six-bar
quick-return mechanism (analysis in closed form and by proven enclosures, sizing by global search),
``arm`` the palletising arm with two parallelograms (inverse kinematics, workspace, statics).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pydantic import BaseModel

from synthesis.machines.linkages.arm import ArmSpec, PalletisingArm, analyse_arm
from synthesis.machines.linkages.shaper import ShaperSpec, SixBarShaper, analyse_or_size_shaper


@dataclass(frozen=True)
class Linkage:
    """A kind of linkage."""

    name: str  # plural, as in ``/v1/linkages/{name}``
    noun: str  # singular, for people
    title: str  # what can be asked
    purpose: str  # what the answer holds
    spec: type[BaseModel]  # the request body
    answer: type[BaseModel]  # the response body
    solve: Callable[[Any, float | None], Any]  # a spec by a deadline [s, monotonic]
    summary: Callable[[Any], dict[str, float]]  # numbers that lists show, by names with units


_KINDS = (
    Linkage(
        name="six-bar-shapers",
        noun="six-bar shaper",
        title="Analyse or size a six-bar shaper",
        purpose="Dead centres in closed form, stroke, quick-return ratio, transmission angle and "
        "the extremes of velocities and accelerations with proven enclosures. Lengths left free as "
        "`{min, max}` are chosen for a stroke and a quick-return ratio that are wanted.",
        spec=ShaperSpec,
        answer=SixBarShaper,
        solve=analyse_or_size_shaper,
        summary=lambda shaper: (
            {}
            if shaper.quick_return is None
            else {"stroke_mm": shaper.stroke_mm, "quick_return_ratio": shaper.quick_return.ratio}
        ),
    ),
    Linkage(
        name="palletising-arms",
        noun="palletising arm",
        title="Analyse a palletising arm",
        purpose="The tool's workspace, with borders of exact arcs and their area; every posture "
        "for each of the poses, with the limits that it exceeds; the torques that hold the load; "
        "the singular arm angles. A place that cannot be reached is a result, not an error: its "
        "`note` says why.",
        spec=ArmSpec,
        answer=PalletisingArm,
        solve=analyse_arm,
        summary=lambda arm: {"reach_mm": arm.reach_mm},
    ),
)
LINKAGES: Mapping[str, Linkage] = MappingProxyType({each.name: each for each in _KINDS})
