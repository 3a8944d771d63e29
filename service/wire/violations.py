"""What pydantic found wrong, told to the caller: pointer, value, rule, way out."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Annotated, Any, get_args

from pydantic import BaseModel, Field
from pydantic_core.core_schema import ErrorType

from service.wire.schema_walk import properties_at

MOST_SHOWN = 50
LONGEST_VALUE = 200
# Rules over several fields: where the caller has to look in the spec, which may be part of a set.
# What stands in braces is among the error's numbers and names.
PLACES = {
    "program_angles": ("program",),
    "program_lift": ("program",),
    "program_still": ("program",),
    "one_number_free": ("program", "{segment}", "{name}"),
    "numbers_do_not_fit": ("program",),
    "states_differ": ("program", "{segment}", "{end}"),
    "state_not_neighbours": ("program", "{segment}"),
    "state_backwards": ("program", "{segment}"),
    "acceleration_alone": ("program", "{segment}"),
    "state_not_met": ("program", "{segment}", "{end}"),
    "law_backwards": ("program", "{segment}"),
    "base_radius_positive": ("base_radius_mm",),
    "offset_beyond_prime_radius": ("follower", "offset_mm"),
    "lift_does_not_suit": ("program", "{position}"),
    "limit_unit_does_not_suit": ("limits", "{position}"),
    "centre_distance_positive": ("follower", "centre_distance_mm"),
    "arm_does_not_reach": ("follower",),
    "roller_on_pivot": ("follower", "arm_mm"),
    "no_length_serves": ("follower", "{name}"),
    "initial_angle_range": ("follower", "initial_angle_deg"),
    "initial_angle_contradicts": ("follower", "initial_angle_deg"),
    "swing_too_large": ("program",),
    "no_best_pressure_angle": ("objective",),
    "no_smallest_cam": ("limits",),
    "pressure_angle_given": ("objective",),
    "limit_does_not_suit": ("limits",),
    "spline_too_rough": ("program", "{position}", "law"),
    "face_turns_with_cam": ("program",),
    "face_swings_too_far": ("follower", "centre_distance_mm"),
    "index_not_whole": ("program",),
    "no_such_size": ("machine", "{name}"),
    "objective_does_not_suit": ("objective",),
    "machine_in_full": ("machine",),
    "nothing_keeps_large": ("limits",),
    "rollers_vanish": ("machine",),
    "crown_leans": ("limits", "{position}"),
    "rollers_overlap": ("machine", "roller_radius_mm"),
    "grooves_reach_axis": ("machine", "centre_distance_mm"),
    "cam_off_the_shaft": ("cams", "{position}", "spec", "{field}"),
    "axis_leads_nowhere": ("axes", "{position}", "{name}"),
    "axes_share_a_field": ("axes", "{position}", "{name}"),
    "balance_needs_numbers": ("axes", "{position}", "{name}"),
    "axis_without_count": ("axes", "{position}"),
    "axes_of_unequal_length": ("axes", "{position}"),
    "wish_missing": ("{name}",),
    "sized_at_constant_speed": ("acceleration_rad_per_s2",),
    "groove_needs_roller": ("follower", "roller_radius_mm"),
    "roller_fills_ring": ("base_radius_mm",),
    "rim_without_ring": ("follower", "closure", "rim_mm"),
    "outer_radius_too_small": ("limits",),
    "load_does_not_suit": ("load", "kind"),
    "nothing_presses_follower": ("load",),
    "friction_does_not_suit": ("load", "friction"),
    "friction_needs_sense": ("load", "friction"),
    "overhang_too_short": ("load", "friction", "overhang_mm"),
    "objective_needs_load": ("objective",),
    "process_not_steady": ("objective",),
    "limit_needs_load": ("limits", "{position}"),
    "limit_needs_contact": ("limits", "{position}"),
    "never_floats": ("limits", "{position}", "min_n"),
    "edge_has_no_pressure": ("limits", "{position}"),
    "vibration_too_far_off": ("limits",),
    "no_dwell_to_ring_in": ("limits",),
    "train_not_held": ("train", "masses"),
    "train_grows": ("train", "masses"),
    "train_resonates": ("speeds_rpm", "{position}"),
    "crown_too_round": ("machine", "crown_radius_mm"),
    "roller_reaches_axis": ("machine", "roller_width_mm"),
    "roller_beside_cylinder": ("machine",),
    "rollers_touch": ("machine", "roller_distance_mm"),
    "arm_along_cam": ("machine", "initial_angle_deg"),
}
SHAPES = ("model_type", "model_attributes_type", "list_type", "dict_type", "float_type")
OBJECTS = ("model_type", "model_attributes_type", "dict_type")
# pydantic's words for a shape, in those of people
PLAIN = {
    **dict.fromkeys(OBJECTS, "must be an object"),
    "list_type": "must be a list",
    "tuple_type": "must be a list",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "string_type": "must be a text",
}
# What is not among these was raised by the core: "rule. Way out." with its numbers.
PYDANTICS_OWN = frozenset(get_args(ErrorType))
COMPARISONS = {
    "greater_than": ("gt", "must be greater than"),
    "greater_than_equal": ("ge", "must be at least"),
    "less_than": ("lt", "must be less than"),
    "less_than_equal": ("le", "must be at most"),
}

Loc = tuple[str | int, ...]
Body = type[BaseModel] | None  # what a document ought to be; None: it is not one


class Violation(BaseModel):
    """One thing that is wrong with the request."""

    pointer: Annotated[
        str | None, Field(description="JSON pointer (RFC 6901) into the body as it was sent.")
    ] = None
    parameter: Annotated[
        str | None, Field(description="Name of the query parameter, path part or header instead.")
    ] = None
    value: Annotated[Any, Field(description="What was found there, shortened where it is long.")]
    rule: Annotated[str, Field(description="What it has to satisfy.")]
    way_out: Annotated[str, Field(description="What to do about it.")]


def shown(value: Any) -> Any:
    """A value fit for a problem document: short, and JSON whatever it holds."""
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else ("Infinity" if value > 0.0 else "-Infinity")
    try:
        text = json.dumps(value, allow_nan=True, default=str, ensure_ascii=False)
    except (ValueError, RecursionError):
        return f"a {type(value).__name__}"
    if isinstance(value, bool | int | float | str | None) and len(text) <= LONGEST_VALUE:
        return value
    plain = len(text) <= LONGEST_VALUE and "NaN" not in text and "Infinity" not in text
    return value if plain else text[: LONGEST_VALUE - 1] + "…"


def pointer_to(path: Sequence[str | int]) -> str:
    """The JSON pointer of a path, '' for the whole document."""
    parts = (str(part).replace("~", "~0").replace("/", "~1") for part in path)
    return "".join(f"/{part}" for part in parts)


def place(body: Any, loc: Loc, kind: str) -> tuple[tuple[str | int, ...], tuple[str, ...]]:
    """The path in the document that pydantic's location names, and the names that are only its own.

    Pydantic inserts the tags of discriminated unions and the names of union members; whatever is
    neither a key nor an index of the document at that point is such a name.
    """
    path: list[str | int] = []
    inserted: list[str] = []
    at = body
    for i, part in enumerate(loc):
        last = i == len(loc) - 1
        if isinstance(at, dict) and part in at:
            at = at[str(part)]
        elif isinstance(at, list) and isinstance(part, int) and part < len(at):
            at = at[part]
        elif not (last and kind == "missing"):
            inserted.append(str(part))
            continue
        path.append(part)
    return tuple(path), tuple(inserted)


def of_body(errors: Sequence[Any], body: Any, model: Body) -> list[dict[str, Any]]:
    """What is wrong with a body that ought to be a ``model``, one entry for each field."""
    by_place: dict[str, list[tuple[dict[str, Any], bool]]] = {}
    members: dict[str, set[bool]] = {}
    for error in errors:
        path, inserted = place(body, error["loc"], error["type"])
        path = _looked_up(error, path)
        if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
            path = (*path, error["ctx"]["discriminator"].strip("'"))
        wrong_shape = error["type"] in SHAPES and any(_is_member(name) for name in inserted)
        entry = {"pointer": pointer_to(path), **_told(error, path, body, model)}
        by_place.setdefault(entry["pointer"], []).append((entry, wrong_shape))
        for name in inserted:
            if _is_member(name):
                whole = pointer_to(place(body, error["loc"][: error["loc"].index(name)], "")[0])
                members.setdefault(whole, set()).add(wrong_shape)
    return _settled(by_place, members)[:MOST_SHOWN]


def _looked_up(error: Any, path: Loc) -> Loc:
    """The path where to look for a rule over several fields, in the spec that it was broken in."""
    if error["type"] not in PLACES:
        return path
    place = [part.format(**error.get("ctx") or {}) for part in PLACES[error["type"]]]
    within = path.index(place[0]) if place[0] in path else len(path)
    return (*path[:within], *place)


def _is_member(name: str) -> bool:
    """Whether a name in a location is that of a union's member rather than a tag."""
    return "[" in name or name.removeprefix("constrained-") in ("float", "int", "str")


def _settled(
    by_place: dict[str, list[tuple[dict[str, Any], bool]]], members: dict[str, set[bool]]
) -> list[dict[str, Any]]:
    """Of the members of a union, leave out those that the value has not even the shape of."""
    told = []
    for pointer, entries in by_place.items():
        better_elsewhere = False in members.get(pointer, set())
        kept = [entry for entry, wrong_shape in entries if not (wrong_shape and better_elsewhere)]
        if len(kept) > 1 and all(wrong for _, wrong in entries):
            first, *rest = dict.fromkeys(entry["rule"] for entry in kept)
            rule = " or ".join([first, *(other.removeprefix("must be ") for other in rest)])
            kept = [{**kept[0], "rule": rule}]
        told += [entry for i, entry in enumerate(kept) if entry not in kept[:i]]
    return told


def _told(error: Any, path: Sequence[str | int], body: Any, model: Body) -> dict[str, Any]:
    kind, ctx, value = error["type"], error.get("ctx") or {}, error.get("input")
    if kind in COMPARISONS:
        key, words = COMPARISONS[kind]
        return _entry(value, f"{words} {ctx[key]:g}", "Give a value within that.")
    if kind == "missing":
        meaning = properties_at(body, path[:-1], model).get(str(path[-1]) if path else "", "")
        return _entry(None, "is required", f"Add it. {meaning}".strip())
    if kind == "extra_forbidden":
        return _entry(value, "is not a field here", _instead(path, body, model))
    if kind in ("union_tag_invalid", "literal_error"):
        allowed = [word.strip(" '") for word in _listed(ctx)]
        tag = ctx.get("tag", value)
        way_out = _guess(tag, allowed) or "Choose one of these."
        return _entry(tag, f"must be one of {', '.join(allowed)}", way_out)
    if kind == "union_tag_not_found":
        return _entry(None, "is required", "Add it: it says which kind of thing this is.")
    if kind == "finite_number":
        return _entry(value, "must be a finite number", "Leave it out, or give a number.")
    if kind in ("too_long", "too_short"):
        most = kind == "too_long"
        bound = ctx["max_length" if most else "min_length"]
        has = f", not {ctx['actual_length']}" if ctx.get("actual_length") is not None else ""
        rule = f"must have at {'most' if most else 'least'} {bound} entries{has}"
        return _entry(value, rule, "Leave some out." if most else "Add what is missing.")
    if kind not in PYDANTICS_OWN:
        rule, _, way_out = error["msg"].partition(". ")
        numbers = (each for each in ctx.values() if isinstance(each, int | float))
        return _entry(ctx.get("value", next(numbers, None)), rule + ".", way_out)
    rule = error["msg"].replace("Input should be", "must be").replace(" or instance of", ":")
    return _entry(value, PLAIN.get(kind, rule), _shaped(kind, value if path else None))


def _shaped(kind: str, value: Any) -> str:
    """The way out where a value has not even the shape of what is asked for."""
    if kind in OBJECTS and isinstance(value, str):
        return f'If that is its kind, write {{"kind": {json.dumps(shown(value))}}}.'
    if kind in ("float_type", "int_type") and isinstance(value, str):
        return "Give a number, without quotes and without a unit: the field's name holds the unit."
    return "Correct it; /docs shows the form and worked examples."


def _entry(value: Any, rule: str, way_out: str) -> dict[str, Any]:
    return {"value": shown(value), "rule": rule, "way_out": way_out}


def _listed(ctx: dict[str, Any]) -> list[str]:
    return str(ctx.get("expected_tags") or ctx.get("expected", "")).replace(" or ", ", ").split(",")


def _nearest(given: Any, allowed: Sequence[str]) -> str:
    return f"{_guess(given, allowed)} Allowed: {', '.join(allowed)}.".strip()


def _guess(given: Any, allowed: Sequence[str]) -> str:
    close = get_close_matches(str(given), allowed, n=1)
    return f"Did you mean {close[0]!r}?" if close else ""


def _instead(path: Sequence[str | int], body: Any, model: Body) -> str:
    allowed = list(properties_at(body, path[:-1], model))
    return _nearest(path[-1], allowed) if allowed else "Remove it."


def of_parameters(errors: Sequence[Any]) -> list[dict[str, Any]]:
    """What is wrong with query parameters, path parts and headers."""
    told = []
    for error in errors[:MOST_SHOWN]:
        name = str(error["loc"][-1])
        entry = _told({**error, "loc": ()}, (name,), {}, None)
        told.append({"parameter": name, **entry})
    return told
