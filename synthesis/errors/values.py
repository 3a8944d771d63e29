"""Wrong values: the rule that each breaks in plain words, and what to write instead."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from synthesis.errors.names import did_you_mean, meant_kind
from synthesis.errors.quantities import field_unit, figure, in_field, pretty, read_quantity
from synthesis.errors.schema import Path, Schema, kinds_of, value_at

LONGEST_VALUE = 200  # characters of a wrong value that are sent back
GIVE_A_NUMBER = "Give a number, or leave the field out where it may be missing."
LEAVE_OUT = "Leave it out, or give a number."
# What people write for a value that they do not give.
NOTHING = frozenset({"", "-", "?", "any", "auto", "automatic", "default", "free", "n/a", "none",
                     "null", "optimal", "tbd"})  # fmt: skip
OBJECTS = ("model_type", "model_attributes_type", "dict_type", "dataclass_type")
NUMBERS = ("float_type", "float_parsing", "int_type", "int_parsing", "int_from_float",
           "int_parsing_size")  # fmt: skip
LISTS = ("list_type", "tuple_type", "iterable_type")
# Shapes in plain words.
PLAIN = {
    **dict.fromkeys(OBJECTS, "must be an object"),
    **dict.fromkeys(LISTS, "must be a list"),
    **dict.fromkeys(NUMBERS[:2], "must be a number"),
    **dict.fromkeys(NUMBERS[2:], "must be a whole number"),
    "string_type": "must be a text",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
}
LEAST = 1e-6  # of a length, an angle or a speed: an end of fields against numbers without meaning
COMPARISONS = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
# Keywords of JSON Schema in words, lower ends first.
BOUNDS = {
    "exclusiveMinimum": "greater than", "minimum": "at least",
    "exclusiveMaximum": "less than", "maximum": "at most",
}  # fmt: skip
BOUND_OF = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
Said = tuple[str, str]  # rule and remedy


def abbreviate(value: Any) -> Any:
    """A value as a problem document shows it: short, and valid JSON."""
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


def out_of_range(error: Any, path: Path, body: Any, schemas: Sequence[Schema]) -> Said:
    """What is said of a number beyond its ends; in a query it comes as a text."""
    value, ctx = float(error["input"]), error["ctx"]
    own = {BOUND_OF[key]: end for key, end in ctx.items() if key in BOUND_OF}
    ends = next((s for s in schemas if own.items() <= s.items()), own)
    words = [f"{word} {figure(ends[key])}" for key, word in BOUNDS.items() if key in ends]
    if value <= 0.0 < ends.get("minimum", 0.0) <= LEAST:  # what no one would call an end
        words[0] = "positive"
    rule = f"must be {' and '.join(words)}"
    moved = _move(value, path, body)
    if moved:
        return rule, moved
    low = max(ends.get("minimum", -math.inf), ends.get("exclusiveMinimum", -math.inf))
    if -math.inf < value < 0.0 <= low < -value:
        return rule, f"Write {figure(-value)}: it has no sign. {_meaning(schemas)}".strip()
    return rule, f"Write a number within that. {_meaning(schemas)}".strip()


def _move(value: Any, path: Path, body: Any) -> str:
    """What to write instead of a lift that is negative or zero; '' where the field is another."""
    name = str(path[-1]) if path else ""
    around = value_at(body, path[:-1])
    kind = around.get("kind") if isinstance(around, Mapping) else None
    if field_unit(name)[0] != "lift" or kind not in ("rise", "return"):
        return ""
    if value == 0:
        return 'A segment without lift is a dwell: write "kind": "dwell" and leave the lift out.'
    if value < 0 and kind == "rise":
        return (
            f'Lifts have no sign: to move back, write "kind": "return" with '
            f'"{name}": {figure(-value)}.'
        )
    if value < 0:
        return f'Write {figure(-value)}: that it moves back is said by "kind": "return".'
    return ""


def _meaning(schemas: Sequence[Schema]) -> str:
    return next((str(each["description"]) for each in schemas if each.get("description")), "")


def not_a_number(
    kind: str, value: Any, path: Path, schemas: Sequence[Schema], required: bool
) -> str:
    """What to write instead of something that is not a number, or not a whole one."""
    field, whole = str(path[-1]) if path else "", kind.startswith("int")
    number = as_number(value, field)
    if number is not None and whole and number != round(number):
        return f"Write {round(number)}, for example."
    if number is not None and isinstance(value, str):
        text, in_json = value.strip(), not kind.endswith("parsing")
        bare = ["without quotes"] if in_json else []
        if not text[-1:].isdigit() or text[:1] in "Øø⌀":
            bare.append("without a unit")
        unit = pretty(field_unit(field)[1])
        why = "" if _says(value) == number else f" ({text}{f' in {unit}' if unit else ''})"
        return f"Write {figure(number)}{why}{', ' if bare else ''}{' and '.join(bare)}."
    if number is not None:
        return f"Write {figure(number)}, by itself."
    nothing = value is None or str(value).strip().casefold() in NOTHING
    if nothing and not required:
        return LEAVE_OUT
    ranges = any("min" in each.get("properties", {}) for each in schemas)
    if ranges and isinstance(value, list) and len(value) == 2:
        return _range(value)
    if isinstance(value, str) and (ranges or not kind.endswith("parsing")):
        unit = pretty(field_unit(field)[1])
        why = f": its unit is {unit}" if unit else ""
        either = ', or {"min": …, "max": …}' if ranges else ""
        return f"Give a number, without quotes and without a unit{either}{why}."
    return f"Give a number. {_meaning(schemas)}".strip()


def _range(ends: Sequence[Any]) -> str:
    if all(isinstance(each, int | float) for each in ends):
        ends = sorted(ends)
    low, high = (json.dumps(abbreviate(each)) for each in ends)
    return f'Write {{"min": {low}, "max": {high}}} for a range.'


def _says(text: str) -> float | None:
    """The number in a text, whatever its unit."""
    quantity = read_quantity(text)
    return None if quantity is None else quantity[0]


def as_number(value: Any, field: str) -> float | None:
    """The number in the field's unit that stands in a text, a list of one, or value and unit."""
    own = field_unit(field)
    if isinstance(value, str):
        quantity = read_quantity(value)
        if quantity is None:
            return None
        number, unit, diameter = quantity
        return in_field(number * (0.5 if diameter and "radius" in own[0] else 1.0), unit, own[1])
    if isinstance(value, list) and len(value) == 1:
        return as_number(value[0], field)
    if isinstance(value, dict) and "value" in value and len(value) <= 2:
        unit = str(value.get("unit", value.get("units", "")))
        return as_number(f"{value['value']} {unit}", field)
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    return None


def not_an_object(value: Any, schemas: Sequence[Schema], path: Path) -> str:
    """What to write where an object belongs."""
    kinds = kinds_of(schemas)
    if isinstance(value, str) and value.lstrip()[:1] in ("{", "["):
        return "Send the JSON itself, not as a text in quotes."
    if isinstance(value, str):
        kind = meant_kind(value, kinds)
        if kind is not None:
            return f'Write {{"kind": "{kind}"}}, with further fields if it has any.'
        if kinds:
            question = did_you_mean(value, kinds)
            return f'{question} Write {{"kind": …}}. The kinds are {", ".join(kinds)}.'.strip()
    if isinstance(value, list) and len(value) == 1 and isinstance(value[0], dict):
        return "Write the object by itself, without brackets around it."
    if isinstance(value, list) and not path:
        return (
            "Send one object. Several cams on one shaft are one request to /v1/cam-sets, many "
            "variations of one design a request to /v1/sweeps."
        )
    ends = any("min" in each.get("properties", {}) for each in schemas)
    if ends and isinstance(value, list) and len(value) == 2:
        return _range(value)
    word = value[0] if isinstance(value, list) and value else None
    kind = meant_kind(word, kinds) if isinstance(word, str) else None
    if kind is not None:
        member = next(each for each in schemas if kind in kinds_of([each]))
        names = [name for name in member.get("required", ()) if name != "kind"]
        inside = "".join(f', "{name}": …' for name in names)
        return f'Write {{"kind": "{kind}"{inside}}}, with the further fields that it has.'
    if kinds:
        return f'Write an object with its "kind" ({", ".join(kinds)}) and the fields of that kind.'
    names = [name for each in schemas for name in each.get("properties", {})]
    listed = ", ".join(f'"{name}"' for name in dict.fromkeys(names))
    return f"Write an object with {listed}." if listed else "Write an object in braces: {…}."


def is_entry(value: Any, items: Sequence[Schema]) -> bool:
    """Whether a value is an entry of a list that lacks the brackets around it."""
    known = {name for each in items for name in each.get("properties", {})}
    named = isinstance(value, dict) and all(meant_kind(name, kinds_of(items)) for name in value)
    return isinstance(value, dict) and not named and not known.isdisjoint(value)


def not_a_list(
    value: Any, schemas: Sequence[Schema], items: Sequence[Schema], required: bool
) -> str:
    """What to write where a list belongs."""
    kinds = kinds_of(items)
    if is_entry(value, items):
        return "Put it in brackets: [{…}]."
    if isinstance(value, dict):
        named = {name: meant_kind(name.rstrip("0123456789"), kinds) for name in value}
        if value and all(named.values()):
            kind = next(iter(named.values()))
            return f'Write a list of objects, each with its kind: [{{"kind": "{kind}", …}}, …].'
    if isinstance(value, str) and kinds:
        kind = meant_kind(value, kinds)
        return f'Write [{{"kind": "{kind or kinds[0]}", …}}].'
    if value is None and not required:
        return "Leave it out, or give a list."
    if kinds:
        return f'Write a list of objects: [{{"kind": …}}, …]. The kinds are {", ".join(kinds)}.'
    parts = next((each["prefixItems"] for each in schemas if "prefixItems" in each), ())
    if parts:
        return f"Write {len(parts)} numbers in brackets: [{', '.join('…' for _ in parts)}]."
    return f"Write a list in brackets: […]. {_meaning(schemas)}".strip()


def which_kind(given: Any, allowed: Sequence[str]) -> tuple[str, str | None]:
    """What to write instead of a word that is not among those allowed; the word, where sure."""
    kind = meant_kind(given, allowed) if isinstance(given, str) else None
    if kind is not None:
        more = (
            ' with "roller_radius_mm": 0' if "knife" in str(given) or "point" in str(given) else ""
        )
        return f'Write "{kind}"{more}.', kind
    digits = [word for word in allowed if word.isdigit() and word in str(given)]
    if isinstance(given, str) and len(digits) == 1:  # a number by a name, such as C2
        return f"Write {digits[0]}, without quotes.", None
    question = did_you_mean(given, allowed) if isinstance(given, str) else ""
    return question or "Choose one of these.", None


def missing_kind(inside: Any, members: Sequence[Schema]) -> str:
    """What to write where the kind is missing, by the fields that are there."""
    names = inside.keys() if isinstance(inside, Mapping) else set()
    fitting = [
        member for member in members
        if names and names <= member.get("properties", {}).keys()
        and set(member.get("required", ())) - {"kind"} <= names
    ]  # fmt: skip
    own = [each for each in fitting if names == each["properties"].keys() - {"kind"}]
    kinds, fit = kinds_of(members), kinds_of(own or fitting)
    if 0 < len(fit) < len(kinds):
        *others, last = map(json.dumps, fit)
        listed = f"{', '.join(others)} or {last}" if others else last
        return f'Add "kind": {listed}, as the other fields say.'
    return f'Add "kind": it is one of {", ".join(kinds)}.'


def add_field(name: str | int, schema: Schema) -> str:
    """What to add where a required field is missing."""
    if isinstance(name, int):
        return "Add what is missing there."
    return f'Add "{name}". {schema.get("description", "")}'.strip()
