"""Quantities as people write them: units in names and in texts, changed into a field's unit."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path
from typing import Any
from unicodedata import normalize

LONGEST_GUESSED = 80  # characters of a wrong name or text that are looked at
DIGITS = 10  # significant digits of a number that is written for the caller: no rounding noise
FEWER = 7  # significant digits of a number that was changed into another unit
LONGEST_UNIT = 5  # words of the longest unit in a name, as in max_mm_per_s_2
LEAST_DIGITS = 3  # significant digits of one that was rounded by the caller, as 1.57 rad
# How the name of a rate continues, and its dimension.
RATES = {f"{per}s{n}": f"/s{n}" for n in ("", "2", "3") for per in ("", "per")}
# Letters and signs that are spelt otherwise in ASCII.
SPELLED = {
    "ø": " diameter ", "⌀": " diameter ", "α": " alpha ", "β": " beta ", "ω": " omega ",
    "φ": " phi ", "ψ": " psi ", "θ": " theta ", "μ": " mu ", "µ": " mu ", "ρ": " rho ",
    "ζ": " zeta ", "ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss",
}  # fmt: skip
_SPELLED = str.maketrans(
    {**SPELLED, **{sign.upper(): word.capitalize() for sign, word in SPELLED.items()
                   if len(sign.upper()) == 1}}
)  # fmt: skip
_ACCENTS = dict.fromkeys(range(0x300, 0x370))  # Unicode's combining marks, left out
BRITISH = {"center": "centre", "millimeter": "millimetre"}
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
THOUSANDS = re.compile(r"(?<![\d.,])[1-9]\d{0,2}(,\d{3})+(?!\d)")  # 1,000: or is it 1.000?
PARTED = re.compile(r"(?<=\d),(?=(\d{3},)*\d{3}\.\d)")  # a comma of 1,000.0: there it is sure
NUMBER = re.compile(
    r"\s*(ø|⌀|Ø)?\s*(?:([-+]?\d+)[ -](?=\d+/\d))?"  # the 1 of 1 3/4
    r"([-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[-+]?\d+)?)(?:/(\d+))?", re.I,
)  # fmt: skip
SIGNS = {"hz": "Hz", "n": "N", "kn": "kN", "pa": "Pa", "mpa": "MPa", "gpa": "GPa", "nm": "N m"}
PURE = "part of one"  # what a field without a unit is measured in, as a tolerance
Unit = tuple[str, float]  # dimension, and factor to the unit of that dimension


@cache
def tables() -> dict[str, Any]:
    """The tables of ``words.toml``, read when the first error needs them."""
    import tomllib  # its regular expressions take a while too

    document: dict[str, Any] = tomllib.loads(
        Path(__file__).with_name("words.toml").read_text("utf-8")
    )
    return document


def words_of(name: str) -> list[str]:
    """The words of a name in lower case, however they are joined: ``baseCircle_mm``.

    Letters have no accents there: ``levée`` is ``levee``.
    """
    found = WORD.findall(normalize("NFD", name[:LONGEST_GUESSED].translate(_SPELLED))
                         .translate(_ACCENTS))  # fmt: skip
    return [BRITISH.get(word, word) for word in map(str.lower, found)]


def joined(name: str) -> str:
    """A name without case, spaces and joints: names that people take for the same are equal."""
    return "".join(words_of(name))


def _unit_key(text: str) -> str:
    text = text.casefold().replace("/", "per").replace("²", "2").replace("³", "3")
    return re.sub(r"[\s_^*·.\-]+", "", text)


@cache
def _units() -> dict[str, list[Unit]]:
    """What each unit's name may mean; those of rates follow from lengths and angles."""
    found: dict[str, list[Unit]] = {}
    for dimension, named in tables()["units"].items():
        for names, factor in named.items():
            for name in names.split(", "):
                found.setdefault(_unit_key(name), []).append((dimension, factor))
                for rate, per in RATES.items() if dimension in ("length", "angle") else ():
                    key = _unit_key(f"{name}{rate}")
                    found.setdefault(key, []).append((f"{dimension}{per}", factor))
    return found


def readings(name: str) -> Iterator[tuple[str, str]]:
    """The ways to part a name: what it says, joined, and the unit behind it, '' for none.

    A name that is a unit throughout, as ``rpm``, says itself.
    """
    words = words_of(name)
    for size in range(min(len(words), LONGEST_UNIT), 0, -1):
        unit = " ".join(words[-size:])
        if _unit_key(unit) in _units():
            yield "".join(words[:-size] or words), unit
    yield "".join(words), ""


def dimensions(unit: str) -> list[str]:
    """What a unit may measure; of '', and of a word that is none, nothing."""
    return [dimension for dimension, _ in _units().get(_unit_key(unit), ())]


def change(value: float, unit: str, into: str) -> float | None:
    """A value in another unit; None where one unit cannot be changed into the other."""
    for dimension, factor in _units().get(_unit_key(unit), ()):
        for other, wanted in _units().get(_unit_key(into), ()):
            if dimension == other:
                return value * factor / wanted
    return None


def read_quantity(text: str) -> tuple[float, str, bool] | None:
    """Number, unit and whether it is a diameter (Ø) of a text as ``0.75 in`` or ``3/4"``.

    None where it is neither, or where a comma may part thousands as well as decimals.
    """
    text = PARTED.sub("", text[: LONGEST_GUESSED + 1])
    match = NUMBER.match(text)
    if match is None or len(text) > LONGEST_GUESSED or THOUSANDS.search(text):
        return None
    sign, whole, number, divisor = match.groups()
    try:
        value = float(number.replace(",", ".")) / float(divisor or 1.0)
        value = math.copysign(abs(float(whole)) + value, float(whole)) if whole else value
    except (ValueError, ZeroDivisionError):
        return None
    unit = text[match.end() :].strip()
    known = not unit or _unit_key(unit) in _units()
    return (value, unit, bool(sign)) if known and math.isfinite(value) else None


def in_field(value: float, unit: str, field_unit: str) -> float | None:
    """A value in a field's unit, rounded as the caller's was; '' stands for the field's own."""
    if not unit or _unit_key(unit) == _unit_key(field_unit):
        return value
    changed = change(value, unit, field_unit or PURE)
    if changed is None:
        return None
    digits = FEWER
    if "rad" in unit.casefold():  # π does not come out even: 1.5708 rad is meant as 90°
        written = len(f"{abs(value):.{DIGITS}g}".replace(".", "").lstrip("0"))
        digits = max(written, LEAST_DIGITS)
    return float(f"{changed:.{digits}g}")


@lru_cache(maxsize=1024)
def field_unit(field: str) -> tuple[str, str]:
    """What a field of the contract says, joined, and its unit: ``baseradius`` and ``mm``."""
    whole = joined(field)
    return next(each for each in readings(field) if each[0] != whole or not each[1])


def pretty(unit: str) -> str:
    """A unit as it is read: ``m/s²`` of ``m per s 2``."""
    text = unit.replace(" per ", "/").replace(" 2", "²").replace(" 3", "³")
    if any("/" in dimension for dimension in dimensions(unit)):
        text = re.sub(r" (s[²³]?)$", r"/\1", text)  # of a name as max_m_s3
    return re.sub(r"[a-z]+", lambda sign: SIGNS.get(sign[0], sign[0]), text)


def figure(value: Any) -> str:
    """A number as JSON has it, without the noise of the last digits."""
    return f"{value:.{DIGITS}g}"
