"""Changed proof files, by something that knows JSON and nothing of what the numbers mean."""

import copy
import json
import random
from collections.abc import Callable, Iterator
from typing import Any

Path = tuple[Any, ...]


def walk(node: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Every place of a JSON document."""
    yield path, node
    parts = (
        node.items()
        if isinstance(node, dict)
        else enumerate(node)
        if isinstance(node, list)
        else ()
    )
    for key, part in parts:
        yield from walk(part, (*path, key))


def at(document: Any, path: Path) -> Any:
    for key in path:
        document = document[key]
    return document


def put(document: Any, path: Path, value: Any) -> None:
    at(document, path[:-1])[path[-1]] = value


def numbers(document: Any) -> list[Path]:
    return [p for p, v in walk(document) if isinstance(v, (int, float)) and not isinstance(v, bool)]


def lists(document: Any, least: int) -> list[Path]:
    return [p for p, v in walk(document) if p and isinstance(v, list) and len(v) >= least]


def digit(text: str, chance: random.Random) -> str:
    """Another digit at one place."""
    places = [k for k, c in enumerate(text) if c.isdigit()]
    k = chance.choice(places)
    return text[:k] + chance.choice([d for d in "0123456789" if d != text[k]]) + text[k + 1 :]


def change_digit(document: Any, chance: random.Random) -> None:
    path = chance.choice(numbers(document))
    text = digit(repr(at(document, path)), chance)
    put(document, path, float(text) if "." in text or "e" in text else int(text))


def change_sign(document: Any, chance: random.Random) -> None:
    path = chance.choice(numbers(document))
    put(document, path, -at(document, path))


def change_size(document: Any, chance: random.Random) -> None:
    path = chance.choice(numbers(document))
    put(document, path, at(document, path) * chance.choice((0.0, 0.5, 0.99, 1.001, 1.1, 2.0, 1e3)))


def leave_out(document: Any, chance: random.Random) -> None:
    path = chance.choice(lists(document, 1))
    del at(document, path)[chance.randrange(len(at(document, path)))]


def write_twice(document: Any, chance: random.Random) -> None:
    path = chance.choice(lists(document, 1))
    at(document, path).append(copy.deepcopy(chance.choice(at(document, path))))


def exchange(document: Any, chance: random.Random) -> None:
    path = chance.choice(lists(document, 2))
    found = at(document, path)
    i, k = chance.sample(range(len(found)), 2)
    found[i], found[k] = found[k], found[i]


def exchange_numbers(document: Any, chance: random.Random) -> None:
    one, other = chance.sample(numbers(document), 2)
    a, b = at(document, one), at(document, other)
    put(document, one, b)
    put(document, other, a)


def change_word(document: Any, chance: random.Random) -> None:
    words = [p for p, v in walk(document) if p and isinstance(v, str)]
    one, other = chance.sample(words, 2)
    put(document, one, at(document, other))


def turn_flag(document: Any, chance: random.Random) -> None:
    flags = [p for p, v in walk(document) if p and isinstance(v, bool)]
    path = chance.choice(flags)
    put(document, path, not at(document, path))


def huge_exponent(document: Any, chance: random.Random) -> None:
    path = chance.choice(numbers(document))
    put(document, path, chance.choice((1e300, 1e-300, 1e60, -1e60, 1e30)))


KINDS: tuple[Callable[[Any, random.Random], None], ...] = (
    change_digit, change_digit, change_digit, change_sign, change_size, leave_out, write_twice,
    exchange, exchange_numbers, change_word, turn_flag, huge_exponent,
)  # fmt: skip


def graft(document: Any, other: Any, chance: random.Random) -> None:
    """A part of another file in place of the same part here."""
    parts = [p for p, v in walk(document) if p and isinstance(v, (dict, list))]
    for path in chance.sample(parts, len(parts)):
        try:
            put(document, path, copy.deepcopy(at(other, path)))
        except (LookupError, TypeError):
            continue
        return


def mutated(document: Any, others: list[Any], chance: random.Random) -> Any:
    """A changed copy of a document, which differs from it."""
    while True:
        result = copy.deepcopy(document)
        if others and chance.random() < 0.1:
            graft(result, chance.choice(others), chance)
        else:
            try:
                chance.choice(KINDS)(result, chance)
            except IndexError:
                continue
        if json.dumps(result) != json.dumps(document):
            return result
