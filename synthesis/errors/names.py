"""What words stand for: names of fields, with the units in them, and of kinds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from functools import cache, lru_cache

from synthesis.errors.quantities import (
    LONGEST_GUESSED,
    field_unit,
    in_field,
    joined,
    readings,
    tables,
    words_of,
)

RADIUS, DIAMETER = "radius", "diameter"
DIAMETERS = (DIAMETER, "dia", "diam", "durchmesser", "d")  # endings of a name that mean one
FACTORS = {(DIAMETER, RADIUS): 0.5, (RADIUS, DIAMETER): 2.0}  # of a value, by what is asked for
# Words that say nothing about which kind is meant.
EMPTY = frozenset({"motion", "law", "curve", "follower", "limit", "cam", "max", "maximum", "min",
                   "type", "peak", "the", "a", "of", "profile", "least", "constraint", "segment",
                   "closure", "deg", "mm", "limits", "allowed", "permissible"})  # fmt: skip
SURE = 0.8  # difflib's ratio from which a name is taken for another one, misspelt


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


def matches(name: str, fields: Iterable[str], moves_in: str) -> Iterable[tuple[str, str, float]]:
    """The fields that a name may stand for, with the unit in the name and the value's factor.

    Args:
        moves_in: the unit in which the follower moves, whose fields come first.
    """
    by_word = _by_word(tuple(fields))
    for stem, unit in readings(name):
        for word, given in _spellings(stem):
            found = by_word.get(word, [])
            for field in sorted(found, key=lambda f: field_unit(f)[1] not in ("", moves_in)):
                says, own = field_unit(field)
                factor = _factor(given, word, says)
                if factor is None:
                    continue
                if says == word == joined(unit):  # a word that is no unit here, as ``turn``
                    yield field, "", factor
                elif not unit or joined(field) == word or in_field(1.0, unit, own) is not None:
                    yield field, unit, factor
