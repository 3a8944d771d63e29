"""The numbers of a spec that constrain the cam, each with the changes that relax it.

A number is named by its path in the spec, as in ``limits/0/rise_deg``, ``base_radius_mm/max`` or
``program/0/points/0/travel_mm``. Everything is in the wire's units; nothing is converted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, TypeVar

from pydantic import BaseModel

from synthesis.catalogue.fields import Range, ends, range_between, without_end
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.limits import Claim, Limit
from synthesis.spec.design_spec import DesignSpec
from synthesis.spec.program import Return, Rise, Segment

Spec = TypeVar("Spec", bound=BaseModel)  # a spec of any machine
BEYOND = 10.0  # factor on a maximum of the base radius: how far a search without it has to reach


@dataclass(frozen=True)
class Relaxable:
    """One number that constrains the cam; limits of one kind and field count as one.

    Attributes:
        name: as in the certificate, words separated by spaces.
        paths: where it stands in the spec. requested: its values there, in the same order.
        unit: of the values.
        sense: ≤ or ≥ for a bound, = for a dimension that is given, ± for a value that is held, and
            relaxed by a deviation either way.
        claim: the field of the claims that it sets, by which their extremes are known.
        dimension: name among the dimensions of a cam; empty for a limit.
        held: of ±: the value held.
        power: with which power of it, at most, what is limited falls as it is relaxed.
        monotone: whether a cam for one value shows that there is one for all that allow more.
        farthest: where it ends; None where it can be left out.
    """

    name: str
    paths: tuple[str, ...]
    requested: tuple[float, ...]
    unit: str
    sense: str
    claim: str = ""
    dimension: str = ""
    held: float = 0.0
    power: float = 1.0
    monotone: bool = True
    farthest: float | None = None

    @property
    def limit(self) -> str:
        """The name with underscores, as on the wire."""
        return self.name.replace(" ", "_")

    @property
    def tightest(self) -> float:
        """The tightest value requested."""
        return max(self.requested) if self.sense == "≥" else min(self.requested)

    @property
    def direction(self) -> float:
        """+1 or −1: towards values that allow more; of a dimension that is given, which is free
        to change either way, +1.
        """
        return -1.0 if self.sense == "≥" else 1.0

    @property
    def minimised(self) -> bool:
        """Whether the smallest cam has the best value of it."""
        return self.paths[0] in ("base_radius_mm", "base_radius_mm/max")

    def __str__(self) -> str:
        value, sign = (self.held, "=") if self.sense == "±" else (self.tightest, self.sense)
        deviation = (
            f" ± {self.tightest:.6g} {self.unit}" if self.sense == "±" and self.tightest else ""
        )
        return f"{self.name} {sign} {value:.6g} {self.unit}{deviation}"

    def value_needed(self, value: float, width: float, bound: float | None) -> float:
        """The value that this number needs for an extreme of a cam to hold.

        Args:
            value, width: of the extreme's enclosure. bound: what the extreme is compared with; its
                sign tells the sides of a limit on both sides apart.
        """
        if self.sense == "±":
            return abs(value - self.held) + width
        if self.sense == "≥":
            return value - width
        return (-value if bound is not None and bound < 0.0 else value) + width

    def values_at(self, value: float) -> Iterator[tuple[str, float, float]]:
        """What changes with it: path, value requested, and value where it is relaxed to another."""
        for path, requested in zip(self.paths, self.requested, strict=True):
            if self.is_tighter(requested, value):
                yield path, requested, value

    def is_tighter(self, requested: float, value: float) -> bool:
        """Whether a requested value excludes what a value allows."""
        if self.sense == "=":
            return requested != value
        return requested > value if self.sense == "≥" else requested < value


def relaxable_numbers(spec: DesignSpec) -> list[Relaxable]:
    """The numbers of a spec that constrain the cam: of limits, windows, points and dimensions."""
    numbers: dict[str, Relaxable] = {}
    for position, limit in enumerate(spec.all_limits()):
        for claim in _claims(spec, limit):
            field = claim.field.rpartition("/")[2]
            if claim.field.startswith("program/") and claim.interval is not None:
                key, number = claim.field, _on_segment(claim)
            elif position < len(spec.limits):
                key, path = f"{limit.kind}/{field}", f"limits/{position}/{field}"
                least = claim.upper is None or field.startswith("min_")
                number = Relaxable(
                    claim.limit.replace("_", " "), (path,), (float(getattr(limit, field)),),
                    claim.unit, "≥" if least else "≤", claim.field,
                )  # fmt: skip
            else:
                continue  # what every cam must keep
            known = numbers.get(key)
            numbers[key] = number if known is None else _merged(known, number)
    return [*numbers.values(), *_dimensions(spec)]


def without(spec: DesignSpec, numbers: Iterable[Relaxable]) -> DesignSpec:
    """The spec without some of its relaxable numbers, and without what then bounds nothing."""
    removed = {path for number in numbers for path in number.paths}
    claimed = {
        position: {claim.field.rpartition("/")[2] for claim in _claims(spec, limit)}
        for position, limit in enumerate(spec.limits)
    }
    empty = set[str]()
    for path in sorted(removed):
        top, *place = path.split("/")
        item = "/".join(path.split("/")[:4])
        if top == "limits":
            fields = {f"limits/{place[0]}/{field}" for field in claimed[int(place[0])]}
            empty |= {f"limits/{place[0]}"} if fields <= removed else set()
        elif top == "program" and "/points/" in path and "/velocity_" not in path:
            empty.add(item)  # a point is its travel
        if path == "base_radius_mm/max":
            spec = _with(spec, [top], _without_maximum(spec))
        elif path == "hub_diameter_mm":  # else the rule for the shaft would give another hub
            spec = spec.model_copy(update={"hub_diameter_mm": None, "shaft_diameter_mm": None})
        elif top != "limits" or f"limits/{place[0]}" not in empty:
            spec = _with(spec, path.split("/"), None)
    for item in sorted(empty):
        spec = _with(spec, item.split("/"), None)
    program = [_without_empty_bounds(segment) for segment in spec.program]
    return spec.model_copy(update={"limits": _present(spec.limits), "program": program})


def _without_maximum(spec: DesignSpec) -> Range | None:
    """The base radius without its maximum, or with one far above where an open range is smaller."""
    opened = without_end(spec.base_radius_mm, "max")
    largest = BEYOND * ends(spec.base_radius_mm)[1]
    if spec.model_copy(update={"base_radius_mm": opened}).searched_radii()[1] >= largest:
        return opened
    return range_between(None if opened is None else opened.min, largest)


def relaxed(spec: Spec, number: Relaxable, value: float) -> Spec:
    """The spec with one number relaxed to a value; what it requests beyond that is unchanged."""
    for path, requested, changed in number.values_at(value):
        *parent, field = place = path.split("/")
        if number.sense == "±":
            spec = _with(spec, parent, _widened(_at(spec, parent), field, changed))
        elif number.sense == "=":
            both = range_between(min(requested, changed), max(requested, changed))
            spec = _with(spec, place, both)
        else:
            spec = _with(spec, place, changed)
    return spec


def _claims(spec: DesignSpec, limit: Limit) -> tuple[Claim, ...]:
    """What a limit claims of a cam, but for that of a counter roller whose place is free."""
    return limit.claims(spec.placed_segments(), spec.without_deferred().machine())


def _without_empty_bounds(segment: Segment) -> Segment:
    """A segment without windows and points that bound nothing any more."""
    if not isinstance(segment, Rise | Return):
        return segment
    points = _present(segment.points)
    windows = [w for w in _present(segment.windows) if any(True for _ in w.bounds())]
    if len(windows) == len(segment.windows) and len(points) == len(segment.points):
        return segment
    return segment.model_copy(update={"windows": windows, "points": points})


def _present(items: Sequence[Any]) -> list[Any]:
    """Those of a list that have not been removed."""
    return [item for item in items if item is not None]


def _merged(known: Relaxable, other: Relaxable) -> Relaxable:
    """Two claims of one number, or two limits of one kind and field, as one."""
    if other.paths[0] in known.paths:
        return known
    return replace(
        known, paths=known.paths + other.paths, requested=known.requested + other.requested
    )


def _on_segment(claim: Claim) -> Relaxable:
    """The bound of a window, or the value that a window or a point holds."""
    name = claim.limit.replace("_", " ")
    given = (end for end in (claim.lower, claim.upper) if end is not None)
    low, *more = sorted(end for end in map(claim.to_wire, given) if end is not None)
    if more:
        half = 0.0 if claim.equality else float(f"{0.5 * (more[0] - low):.12g}")
        middle = float(f"{0.5 * (low + more[0]):.12g}")
        return Relaxable(name, (claim.field,), (half,), claim.unit, "±", claim.field, held=middle)
    sense = "≥" if claim.field.endswith("/min") else "≤"
    return Relaxable(name, (claim.field,), (float(f"{low:.15g}"),), claim.unit, sense, claim.field)


def _dimensions(spec: DesignSpec) -> Iterator[Relaxable]:
    """The ends of the base radius and of the follower's dimensions, as far as they are given."""
    follower = spec.follower
    given = {"base_radius_mm": ("base_radius_mm", spec.base_radius_mm)}
    given |= {f"follower/{f}": (f, value) for f, value in follower.adjustable_dimensions().items()}
    given |= {f"follower/{f}": pair for f, pair in follower.closure.counter_dimensions().items()}
    for name, diameter in (("hub", spec.hub_diameter_mm), ("shaft", spec.shaft_diameter_mm)):
        if diameter is not None:  # a shaft's hub counts where no other is given
            yield Relaxable(
                f"room for {name}", (f"{name}_diameter_mm",), (diameter,), "mm", "≥",
                f"{name}_diameter_mm", dimension="base_radius_mm",
            )  # fmt: skip
            break
    for path, (dimension, value) in given.items():
        low, high = ends(value)
        sides = [("=", low, "")] if low == high else [("≥", low, "/min"), ("≤", high, "/max")]
        title, _, unit = dimension.rpartition("_")
        for sense, end, tail in sides:
            if isfinite(end) and not _measures_displacement(follower, path, tail):
                yield Relaxable(
                    title.replace("_", " "), (path + tail,), (end,), unit, sense,
                    dimension=dimension,
                )  # fmt: skip


def _measures_displacement(follower: Follower, path: str, tail: str) -> bool:
    """Whether displacements are measured by this end of a dimension: it cannot be left out."""
    _, _, name = path.partition("/")
    if name not in type(follower).model_fields:
        return False
    open_end = without_end(getattr(follower, name), tail.lstrip("/"))
    return not isfinite(follower.model_copy(update={name: open_end}).travel.per_unit)


def _at(value: Any, path: Sequence[str]) -> Any:
    """What stands at a path."""
    for step in path:
        value = value[int(step)] if isinstance(value, list) else getattr(value, step)
    return value


def _with(value: Any, path: Sequence[str], new: Any) -> Any:
    """A copy of a model or list with something else at a path; nothing is validated anew."""
    if not path or value is None:
        return new
    head, *rest = path
    if isinstance(value, list):
        changed = list(value)
        changed[int(head)] = _with(value[int(head)], rest, new)
        return changed
    return value.model_copy(update={head: _with(getattr(value, head), rest, new)})


def _widened(item: BaseModel, field: str, deviation: float) -> BaseModel:
    """A window or point that holds a value, with a deviation allowed either way."""
    if field.startswith("tolerance_"):
        return item.model_copy(update={field: deviation})
    tolerance = f"tolerance_{field.partition('_')[2]}"
    if field.startswith("travel_") and tolerance in type(item).model_fields:
        return item.model_copy(update={tolerance: deviation})
    low, high = ends(getattr(item, field))
    return item.model_copy(update={field: range_between(low - deviation, high + deviation)})
