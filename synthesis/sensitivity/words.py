"""What a number costs as a person would say it."""

from __future__ import annotations

import re
from collections.abc import Iterator

from synthesis.sensitivity.numbers import Asked
from synthesis.sensitivity.slopes import Slopes

MANY = 1000.0  # numbers from here on are told for one per cent more instead of one unit
UNIT = re.compile(r"(?P<name>.+)_(?P<unit>mm|deg|hz)(?P<per>_per_s(?P<power>[23])?)?")


def words(number: Asked, slopes: Slopes, objective: str) -> str:
    """As in: 1 deg more in /limits/0/rise_deg makes base_radius 0.8 mm smaller."""
    if slopes.more == slopes.less == 0.0:
        return f"{number.pointer} does not decide"
    one = slopes.more if slopes.more == slopes.less else None
    if one is not None:
        return f"{_step(number)} more in {number.pointer} makes {_change(number, one, objective)}"
    said = "; ".join(_sides(number, slopes, objective))
    return f"{number.pointer} stands at a corner: {said}"


def _sides(number: Asked, slopes: Slopes, objective: str) -> Iterator[str]:
    for way, sign, slope in (("more", 1.0, slopes.more), ("less", -1.0, slopes.less)):
        if slope is None:
            yield f"{way} has no cam beside this one"
        elif slope == 0.0:
            yield f"{way} changes nothing"
        else:
            yield f"{_step(number)} {way} makes {_change(number, sign * slope, objective)}"


def _step(number: Asked) -> str:
    """One unit, or one per cent of a large number."""
    if abs(number.asked) >= MANY:
        return "1 %"
    unit = next((unit for part in reversed(number.path) if (unit := _with_unit(part)[1])), "")
    return f"1 {unit}"


def _change(number: Asked, slope: float, objective: str) -> str:
    name, unit = _with_unit(objective)
    change = slope if abs(number.asked) < MANY else 0.01 * slope * abs(number.asked)
    way = "larger" if change > 0.0 else "smaller"
    return f"{name} {abs(change):.4g} {unit} {way}"


def _with_unit(field: str | int) -> tuple[str, str]:
    """A field's name without its unit, and the unit: max, mm/s³ of max_mm_per_s3."""
    found = UNIT.fullmatch(str(field))
    if found is None:
        return str(field), ""
    power = {"2": "²", "3": "³"}.get(found["power"] or "", "")
    unit = found["unit"].replace("hz", "Hz")
    return found["name"], unit + (f"/s{power}" if found["per"] else "")
