"""What an unknown name stands for, and what to write instead: names of fields, and of kinds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache, lru_cache
from typing import Any

from synthesis.errors.quantities import (
    LONGEST_GUESSED,
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

RADIUS, DIAMETER = "radius", "diameter"
DIAMETERS = (DIAMETER, "dia", "diam", "durchmesser", "d")  # endings of a name that mean one
FACTORS = {(DIAMETER, RADIUS): 0.5, (RADIUS, DIAMETER): 2.0}  # of a value, by what is asked for
OF_FACTOR = {0.5: ", half of the diameter", 2.0: ", twice the radius", 1.0: ""}
# Words that say nothing about which kind is meant.
EMPTY = frozenset({"motion", "law", "curve", "follower", "limit", "cam", "max", "maximum", "min",
                   "type", "peak", "the", "a", "of", "profile", "least", "constraint", "segment",
                   "closure", "deg", "mm", "limits", "allowed", "permissible"})  # fmt: skip
SURE = 0.8  # difflib's ratio from which a name is taken for another one, misspelt
TELLING = 4  # letters of a name from which it may be meant as a field far away
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
        _own_kind, _sentence, _in_place, _end_of_range, _envelope, _kind_below, _elsewhere,
    )  # fmt: skip
    found = (rule(wrong, fields) for rule in rules)
    return next((each for each in found if each is not None), None) or _misspelt(wrong, fields)


def meant_kind(given: str, allowed: Sequence[str]) -> str | None:
    """The kind that a word stands for, of those allowed; None where it is none of ours."""
    core = "".join(word for word in words_of(given) if word not in EMPTY)
    for word in (joined(given), core):
        rights = {word} | _meanings("kinds").get(word, frozenset())
        for kind in allowed:
            if word and joined(kind) in rights:
                return kind
    return None


def right_name(name: str, fields: Iterable[str]) -> str | None:
    """The field that a name stands for, by another word or misspelt; None where it is unsure."""
    known = tuple(fields)
    by_word = _by_word(known)
    for stem, _ in readings(name):
        if by_word.get(stem):
            return by_word[stem][0]
    return next(iter(get_close_matches(name[:LONGEST_GUESSED], known, 1, SURE)), None)


def did_you_mean(given: str, allowed: Iterable[str]) -> str:
    """A question where a name looks like one of those allowed, else ''."""
    close = get_close_matches(given[:LONGEST_GUESSED], list(allowed), n=1)
    return f"Did you mean {close[0]!r}?" if close else ""


@cache
def _meanings(table: str) -> Mapping[str, frozenset[str]]:
    """What each word of ``words.toml`` may stand for, all names joined."""
    found: dict[str, set[str]] = {}
    for right, words in tables()[table].items():
        for word in words.split(", "):
            found.setdefault(joined(word), set()).add(joined(right))
    return {word: frozenset(rights) for word, rights in found.items()}


@lru_cache(maxsize=256)
def _by_word(fields: tuple[str, ...]) -> Mapping[str, list[str]]:
    """The fields that each word may stand for: those that say just that first."""
    own: dict[str, list[str]] = {}
    other: dict[str, list[str]] = {}
    words: dict[str, list[str]] = {}
    for word, rights in _meanings("fields").items():
        for right in rights:
            words.setdefault(right, []).append(word)
    for field in fields:
        for said in {joined(field), field_unit(field)[0]}:
            own.setdefault(said, []).append(field)
            for word in words.get(said, ()):
                other.setdefault(word, []).append(field)
    return {w: [*own.get(w, ()), *other.get(w, ())] for w in own.keys() | other.keys()}


def _sentence(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The sentence of the table on a name, where the place has the fields that it speaks of."""
    said = {stem for stem, _ in readings(wrong.name)}
    for names, beside, text in _sentences():
        if beside <= fields.keys() and not said.isdisjoint(names):
            return Answer(text.format(value=_in_json(wrong.value)))
    return None


@cache
def _sentences() -> list[tuple[set[str], set[str], str]]:
    """The names, joined, the fields beside them, and what is said."""
    return [
        ({joined(word) for word in each["names"].split(", ")}, set(each["beside"]), each["text"])
        for each in tables()["sentences"]
    ]


def _in_json(value: Any) -> str:
    return figure(value) if _is_number(value) else "…"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _spellings(stem: str) -> list[tuple[str, str]]:
    """What a name may say, each with the measure of a circle that its value is, '' for none."""
    found = [(stem, next((each for each in (RADIUS, DIAMETER) if stem.endswith(each)), ""))]
    for ending in DIAMETERS:
        if stem.endswith(ending):
            core = stem.removesuffix(ending)
            found += [(f"{core}{measure}", DIAMETER) for measure in (DIAMETER, RADIUS, "")]
    if stem.endswith(RADIUS):
        found.append((stem.removesuffix(RADIUS) + DIAMETER, RADIUS))
    return found


def _factor(given: str, word: str, says: str) -> float | None:
    """What a value is multiplied by under a field; None where a diameter is no measure of it.

    Args:
        given: radius, diameter or '', as the name says. word: that led to the field.
        says: the field's name without its unit.
    """
    wanted = next((m for name in (says, word) for m in (RADIUS, DIAMETER) if name.endswith(m)), "")
    if given == DIAMETER and not wanted:
        return None
    return FACTORS.get((given, wanted), 1.0)


def _matches(wrong: Wrong, fields: Iterable[str]) -> Iterable[tuple[str, str, float]]:
    """The fields that a name may stand for, with the unit in the name and the value's factor."""
    by_word = _by_word(tuple(fields))
    for stem, unit in readings(wrong.name):
        for word, given in _spellings(stem):
            found = by_word.get(word, [])
            for field in sorted(found, key=lambda f: field_unit(f)[1] not in ("", wrong.moves_in)):
                says, own = field_unit(field)
                factor = _factor(given, word, says)
                if factor is None:
                    continue
                if says == word == joined(unit):  # a word that is no unit here, as ``turn``
                    yield field, "", factor
                elif not unit or joined(field) == word or in_field(1.0, unit, own) is not None:
                    yield field, unit, factor


def _in_place(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The field that a name stands for here by another word, another unit, or as a diameter."""
    for field, unit, factor in _matches(wrong, fields):
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
    number, why = value if _is_number(value) else None, OF_FACTOR[factor]
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
    for field, unit, factor in _matches(replace(wrong, path=(*wrong.path[:-1], bare)), fields):
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


def _with_fields(kind: str, members: Sequence[Schema]) -> str:
    """The other fields of a kind, in words."""
    own = next(each for each in members if kind in kinds_of([each]))["properties"]
    names = ", ".join(f'"{name}"' for name in own if name != "kind")
    return f", with {names}" if names else ""


def _envelope(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """A body within another one, as ``{"spec": {…}}``."""
    value = wrong.value
    inside = value.keys() & fields.keys() if isinstance(value, dict) else ()
    if len(wrong.path) > 1 or len(inside) < 2:
        return None
    return Answer(f'Send what is in "{wrong.name}", without "{wrong.name}" around it.', (), value)


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


def _only_kind(wrong: Wrong, members: Sequence[Schema]) -> str:
    """The kind that a name says word for word where no field says so; '' for none."""
    assert wrong.model is not None
    stems = {stem for stem, _ in readings(wrong.name)}
    if any(field_unit(name)[0] in stems for name in places(wrong.model)):
        return ""
    return next((kind for kind in kinds_of(members) if joined(kind) in stems), "")


def _elsewhere(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer | None:
    """The field of this name, or that it stands for, at another place of the body."""
    assert wrong.model is not None
    here = tuple("…" if isinstance(part, int) else part for part in wrong.path[:-1])
    everywhere = {
        field: [place for place in found if place != here]
        for field, found in places(wrong.model).items() if field != "kind"
    }  # fmt: skip
    for field, unit, factor in _matches(wrong, everywhere):
        others = everywhere[field]
        same = joined(field) == joined(wrong.name)
        if not others or not (same or (len(others) <= SEVERAL and _is_telling(wrong, field))):
            continue
        written, why, value = _value_for(field, wrong, unit, factor, [])
        what = f'"{field}": {written or "…"}'
        place = others[0]
        if place and "…" not in place:
            # Where the object is there and has no such field, the value is sure to be meant there.
            inside = value_at(wrong.body, place)
            lacks = isinstance(inside, dict) and field not in inside
            form = f'"{place[-1]}": {{{what}}}'
            where = "/".join(str(part) for part in place)
            to = (*place, field) if lacks else None
            return Answer(f"Write it into {where}: {form}{why}.", to, value)
        where = "/".join(str(part) for part in place if part != "…")
        within = f"each entry of {where}" if place else "the request itself"
        return Answer(f"Write it into {within}: {what}{why}.")
    return None


def _is_telling(wrong: Wrong, field: str) -> bool:
    """Whether a name says enough to be meant as a field far away: not so ``to``, or ``max``."""
    return min(len(joined(wrong.name)), len(field_unit(field)[0])) >= TELLING


def _misspelt(wrong: Wrong, fields: Mapping[str, Schema]) -> Answer:
    name = wrong.name[:LONGEST_GUESSED]
    if wrong.around.get("kind") == "dwell" and field_unit(name)[0] == "lift":
        return Answer("Remove it: a dwell has no lift.")
    listed = f"{did_you_mean(name, fields)} Allowed: {', '.join(fields)}.".strip()
    close = get_close_matches(name, [f for f in fields if f not in wrong.around], 1, SURE)
    return Answer(listed, (*wrong.path[:-1], close[0]), wrong.value) if close else Answer(listed)
