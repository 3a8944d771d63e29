"""What to write instead of a name that no field has where it stands."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache
from typing import Any

from synthesis.errors.names import SURE, did_you_mean, matches, meant_kind
from synthesis.errors.quantities import (
    LONGEST_GUESSED,
    dimensions,
    field_unit,
    figure,
    in_field,
    joined,
    pretty,
    read_quantity,
    readings,
    tables,
    words_of,
)
from synthesis.errors.schema import (
    Body,
    Loc,
    Schema,
    fields_at,
    kinds_of,
    places,
    schemas_at,
    value_at,
)

OF_FACTOR = {0.5: ", half of the diameter", 2.0: ", twice the radius", 1.0: ""}
TELLING = 4  # letters of a name from which it may be meant as a field far away
LEAST_TELLING = 3  # letters of such a field, as "law"
ENDS = ("min", "max")  # fields of every range: of a name far away none is meant
# Words of a name that bounds something beside what it bounds.
BOUNDING = frozenset({"max", "maximum", "min", "minimum", "limit", "allowed", "permissible"})
SEVERAL = 4  # places in which a name may stand; of more, none is proposed


@dataclass(frozen=True)
class Answer:
    """What is said of a wrong name: what to write; if that is sure, where and which value.

    ``to``: the path in the document where the value belongs; () where it is the document.
    """

    remedy: str
    to: Loc | None = None
    value: Any = None


@dataclass(frozen=True)
class Wrong:
    """A name that no field has: its path in a body that ought to be a ``model``."""

    path: Loc
    body: Any
    model: Body

    @property
    def name(self) -> str:
        """The name itself."""
        return str(self.path[-1])

    @property
    def value(self) -> Any:
        """What stands under it."""
        return value_at(self.body, self.path)

    @property
    def around(self) -> Mapping[str, Any]:
        """The object that it stands in."""
        around = value_at(self.body, self.path[:-1])
        return around if isinstance(around, dict) else {}

    def fields(self) -> dict[str, Schema]:
        """The fields that there are in its place."""
        return fields_at(self.body, self.path[:-1], self.model)

    @property
    def moves_in(self) -> str:
        """The unit in which the follower of the request around it moves."""
        for size in range(len(self.path), -1, -1):
            follower = value_at(self.body, [*self.path[:size], "follower"])
            if isinstance(follower, dict):
                return "deg" if "oscillating" in str(follower.get("kind")) else "mm"
        return "mm"


def answer_name(path: Loc, body: Any, model: Body) -> Answer:
    """What to write instead of the name at ``path``, which no field has there."""
    wrong = Wrong(path, body, model)
    fields = wrong.fields()
    if not fields:
        return Answer("Remove it.")
    rules: tuple[Callable[[Wrong, dict[str, Schema]], Answer | None], ...] = (
        _own_kind, _second_kind, _sentence, _in_place, _end_of_range, _envelope, _kind_beside,
        _kind_below, _other_kind, _elsewhere,
    )  # fmt: skip
    found = (rule(wrong, fields) for rule in rules)
    return next((each for each in found if each is not None), None) or _misspelt(wrong, fields)


def _sentence(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The sentence of the table on a name, where the place has the fields that it speaks of."""
    said = list(readings(wrong.name))
    for names, beside, of, text in _sentences():
        spoken = any(stem in names and of in (*dimensions(unit), "") for stem, unit in said)
        if beside <= fields.keys() and spoken:
            return Answer(text.format(value=_in_json(wrong.value)))
    return None


@cache
def _sentences() -> list[tuple[set[str], set[str], str, str]]:
    """The names, joined, the fields beside them, the dimension in the name, and what is said."""
    return [
        ({joined(word) for word in each["names"].split(", ")}, set(each["beside"]),
         each.get("of", ""), each["text"])
        for each in tables()["sentences"]
    ]  # fmt: skip


def _in_json(value: Any) -> str:
    return figure(value) if _is_number(value) else "…"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _in_place(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The field that a name stands for here by another word, another unit, or as a diameter."""
    for field, unit, factor in matches(wrong.name, fields, wrong.moves_in):
        if field in wrong.around:
            return Answer(f'Remove it: "{field}" is given already.')
        members = schemas_at(wrong.body, [*wrong.path[:-1], field], wrong.model)
        if field == "kind":
            members = schemas_at(wrong.body, wrong.path[:-1], wrong.model)
        written, why, value = _value_for(field, wrong, unit, factor, members)
        what = f'"{field}": {written}' if written else f'"{field}" instead of "{wrong.name}"'
        return Answer(f"Write {what}{why}.", (*wrong.path[:-1], field), value)
    return None


def _value_for(
    field: str, wrong: Wrong, unit: str, factor: float, members: Sequence[Schema]
) -> tuple[str, str, Any]:
    """What to write under a field, '' for the value as it is; why; and the value."""
    value, own = wrong.value, field_unit(field)[1]
    numeric = not members or any(each.get("type") in ("number", "integer") for each in members)
    number, why = value if _is_number(value) and numeric else None, OF_FACTOR[factor]
    if isinstance(value, str):
        kind = meant_kind(value, kinds_of(members))
        if kind is not None and field == "kind":
            return f'"{kind}"', "", kind
        if kind is not None:
            return f'{{"kind": "{kind}", …}}', "", {"kind": kind}
        quantity = read_quantity(value)
        if quantity is not None and own:
            number, unit = quantity[0], quantity[1] or unit
    changed = None if number is None else in_field(number * factor, unit, own)
    if number is None or changed is None:
        other_unit = unit and own and in_field(1.0, unit, own) != 1.0
        return "", f"{why}: its unit is {pretty(own)}" if other_unit else why, value
    if changed != number * factor:
        why = f"{why} ({figure(number)} {pretty(unit)})"
    return figure(changed), why, changed


def _end_of_range(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """A field that may be a range, where a name says which end of it: ``base_radius_min``."""
    words = words_of(wrong.name)
    end = next((end for end in ("min", "max") if end in words), None)
    if end is None:
        return None
    bare = "_".join(word for word in words if word != end)
    # The other end, where it stands beside: one range is written for both.
    other = "max" if end == "min" else "min"
    twin = [other if word == end else word for word in words]
    beside = next((name for name in wrong.around if words_of(name) == twin), None)
    for field, unit, factor in matches(bare, fields, wrong.moves_in):
        members = schemas_at(wrong.body, [*wrong.path[:-1], field], wrong.model)
        if any(end in member.get("properties", {}) for member in members):
            written, why, value = _value_for(field, wrong, unit, factor, [])
            ends: dict[str, str] = {end: written or "…"}
            if beside is not None:
                far = replace(wrong, path=(*wrong.path[:-1], beside))
                ends[other] = _value_for(field, far, unit, factor, [])[0] or "…"
            inside = ", ".join(f'"{name}": {ends[name]}' for name in sorted(ends, reverse=True))
            to = None if field in wrong.around else (*wrong.path[:-1], field)
            return Answer(f'Write "{field}": {{{inside}}}{why}.', to, {end: value})
    return None


def _own_kind(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """A kind where the name of a field belongs, as ``{"rise": {"angle_deg": 60}}``."""
    members = schemas_at(wrong.body, wrong.path[:-1], wrong.model)
    kind = meant_kind(wrong.name, kinds_of(members)) if len(members) > 1 else None
    if kind is None or "kind" in wrong.around:
        return None
    to = (*wrong.path[:-1], "kind")
    return Answer(f'Write "kind": "{kind}"{_with_fields(kind, members)}.', to, kind)


def _second_kind(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """Another kind than the object's own, where a list of such objects may stand in its place.

    As ``{"base_radius": 0.5, "jerk": 0.5}``, of which the first is taken for the kind.
    """
    place = wrong.path[:-1]
    members, own = schemas_at({}, place, wrong.model), wrong.around.get("kind")
    bounds = not BOUNDING.isdisjoint(words_of(wrong.name))  # a limit is meant
    kind = None if bounds else meant_kind(wrong.name, kinds_of(members))
    if kind is None or not isinstance(own, str) or not any("items" in each for each in members):
        return None
    both = ", ".join(f'{{"kind": "{each}"}}' for each in (own, kind))
    return Answer(f"Each object has one kind. Write a list, the most important first: [{both}].")


def _with_fields(kind: str, members: Sequence[Schema]) -> str:
    """The other fields of a kind, in words."""
    own = next(each for each in members if kind in kinds_of([each]))["properties"]
    names = _listed(name for name in own if name != "kind")
    return f", with {names}" if names else ""


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _envelope(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """A body within another one, as ``{"spec": {…}}``, or a part of it, as ``{"cam": {…}}``."""
    value = wrong.value
    inside = value.keys() & fields.keys() if isinstance(value, dict) else set()
    if len(wrong.path) > 1 or len(inside) < 2:
        return None
    rest = {name: each for name, each in wrong.around.items() if name != wrong.name}
    beside = " beside the others" if rest.keys() & fields.keys() else ""
    what = f'Send what is in "{wrong.name}"{beside}'
    return Answer(f'{what}, without "{wrong.name}" around it.', (), {**rest, **value})


def _kind_beside(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """A field whose value has a kind, where the name says just that, or the value does.

    As ``"groove": true`` and ``"contact": "groove"`` for ``"closure": {"kind": "groove"}``.
    """
    value, said = wrong.value, wrong.value
    if value is True or isinstance(value, dict):
        said = None if _is_field(wrong) else wrong.name
    for field in fields if isinstance(said, str) else ():
        members = schemas_at(wrong.body, (*wrong.path[:-1], field), wrong.model)
        kind = meant_kind(str(said), kinds_of(members))
        if kind is not None and field not in wrong.around:
            inside = value if isinstance(value, dict) else {}
            to = (*wrong.path[:-1], field)
            written = f'{{"kind": "{kind}"{", …" if inside else ""}}}'
            return Answer(f'Write "{field}": {written}.', to, {"kind": kind, **inside})
    return None


def _kind_below(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The kind of a limit, or of an objective, that ought to stand in a field of this object.

    Or in one of an object around: there the kind of just this name, which no field has.
    """
    for size in range(len(wrong.path) - 1, -1, -1):
        around = wrong.path[:size]
        for field, entry in (("limits", (0,)), ("objective", ())):
            if field not in fields_at(wrong.body, around, wrong.model):
                continue
            members = schemas_at({}, (*around, field, *entry), wrong.model)
            given = wrong.name if size == len(wrong.path) - 1 else _only_kind(wrong, members)
            kind = meant_kind(given, kinds_of(members))
            if kind is None:
                continue
            more = _with_fields(kind, members)
            inner = f'{{"kind": "{kind}"{", …" if more else ""}}}'
            return Answer(f'Write it into "{field}": {f"[{inner}]" if entry else inner}{more}.')
    return None


def _other_kind(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """A field of other kinds than the object's own, as an offset of a follower that swings."""
    members, own = schemas_at({}, wrong.path[:-1], wrong.model), wrong.around.get("kind")
    if own not in kinds_of(members) or own == "dwell":  # what a dwell lacks is told in its words
        return None
    having = [each for each in members if wrong.name in each.get("properties", {})]
    kinds = kinds_of(having)
    if not 0 < len(kinds) <= SEVERAL:
        return None
    other = f'"kind": {" or ".join(map(json.dumps, kinds))}'
    return Answer(
        f'Remove it: "kind": "{own}" has no {wrong.name}. Or write {other}, which has it.'
    )


def _only_kind(wrong: Wrong, members: Sequence[Schema]) -> str:
    """The kind that a name says word for word where no field says so; '' for none.

    Words that say that it bounds something may stand beside it, as in ``max_velocity``.
    """
    if _is_field(wrong):
        return ""
    stems = {stem for stem, _ in readings(wrong.name)}
    bounded = "_".join(word for word in words_of(wrong.name) if word not in BOUNDING)
    stems |= {stem for stem, _ in readings(bounded)}
    return next((kind for kind in kinds_of(members) if joined(kind) in stems), "")


def _is_field(wrong: Wrong) -> bool:
    """Whether a field at any place of the body says just this."""
    assert wrong.model is not None
    stems = {stem for stem, _ in readings(wrong.name)}
    return any(field_unit(name)[0] in stems for name in places(wrong.model))


def _elsewhere(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The field of this name, or that it stands for, at another place of the body.

    Of several places the one that shares most of the way with the name's own.
    """
    assert wrong.model is not None
    here = tuple("…" if isinstance(part, int) else part for part in wrong.path[:-1])
    everywhere = {
        field: [place for place in found if place != here]
        for field, found in places(wrong.model).items() if field != "kind"
    }  # fmt: skip
    for field, unit, factor in matches(wrong.name, everywhere, wrong.moves_in):
        others = everywhere[field]
        same = joined(field) == joined(wrong.name)
        if not 0 < len(others) <= SEVERAL or not (same or _is_telling(wrong, field)):
            continue
        place = max(others, key=lambda other: _shared(other, here))
        common = _shared(place, here)
        path = (*wrong.path[:common], *place[common:])  # with the numbers of entries, where known
        entries = (0 if part == "…" else part for part in path)
        members = schemas_at(wrong.body, (*entries, field), wrong.model)
        written, why, value = _value_for(field, wrong, unit, factor, members)
        if any(wrong.value in each.get("enum", [each.get("const")]) for each in members):
            written = f'"{wrong.value}"'
        shapes = [each for each in members if each.get("type") != "null"]
        objects = all(each.get("type") == "object" for each in shapes) and bool(shapes)
        wants = objects and not isinstance(wrong.value, dict) and written[:1] != "{"
        if wants:
            written, why = "{…}", f", with {_listed(shapes[0]['properties'])}"
        what = f'"{field}": {written or "…"}'
        if path and "…" not in path:
            # Where the object is there and has no such field, the value is sure to be meant there.
            inside = value_at(wrong.body, path)
            lacks = isinstance(inside, dict) and field not in inside
            kind = "" if isinstance(inside, dict) else _kind_of_field(wrong, path, field)
            form = what if isinstance(path[-1], int) else f'"{path[-1]}": {{{kind}{what}}}'
            where = "/".join(str(part) for part in path)
            to = (*path, field) if lacks and not wants else None
            return Answer(f"Write it into {where}: {form}{why}.", to, value)
        where = "/".join(str(part) for part in path if part != "…")
        within = f"each entry of {where}" if path else "the request itself"
        return Answer(f"Write it into {within}: {what}{why}.")
    return None


def _shared(place: Loc, here: Loc) -> int:
    """How many parts at their beginning two paths share."""
    pairs = zip(place, here, strict=False)
    return next((i for i, (one, other) in enumerate(pairs) if one != other),
                min(len(place), len(here)))  # fmt: skip


def _kind_of_field(wrong: Wrong, path: Loc, field: str) -> str:
    """The kind that an object at ``path`` needs to have a field, as it is written before it."""
    own = [
        each for each in schemas_at({}, path, wrong.model) if field in each.get("properties", {})
    ]
    kinds = dict.fromkeys(kinds_of(own))
    return f'"kind": "{next(iter(kinds))}", ' if len(kinds) == 1 else ""


def _is_telling(wrong: Wrong, field: str) -> bool:
    """Whether a name says enough to be meant as a field far away: not so ``to``, or ``max``."""
    says, unit = field_unit(field)
    if says in ENDS or len(says) < LEAST_TELLING:
        return False
    return len(joined(wrong.name)) >= TELLING or joined(wrong.name) == joined(unit)


def _misspelt(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer:
    name = wrong.name[:LONGEST_GUESSED]
    if wrong.around.get("kind") == "dwell" and field_unit(name)[0] == "lift":
        return Answer("Remove it: a dwell has no lift.")
    listed = f"{did_you_mean(name, fields)} Allowed: {', '.join(fields)}.".strip()
    close = get_close_matches(name, [f for f in fields if f not in wrong.around], 1, SURE)
    return Answer(listed, (*wrong.path[:-1], close[0]), wrong.value) if close else Answer(listed)
