"""Units: the systems in use, and the functions that change from one to the next.

====================  ========  =========  ==================  ======  ======  ==================
system                length    cam angle  derivatives of s    time    force   where
====================  ========  =========  ==================  ======  ======  ==================
wire, sliding         mm        deg        mm/s, mm/s², …      s, rpm  N, MPa  bodies, files
wire, swinging (arm)  deg of s  deg        deg/s, deg/s², …    s, rpm  N, MPa  bodies, files
core                  mm        rad        s', s'', … per rad  s       N       catalogue, certify
problem               L         rad        s', s'', … per rad  T       N       optimise
conic program         stroke    x in 0..1  g', g'', … of g(x)  –       –       optimise/conic
====================  ========  =========  ==================  ======  ======  ==================

Masses are in kg everywhere. Every change of units happens in one place:

* Field names on the wire end with their unit (``lift_mm``, ``speed_rpm``).
* wire → core: ``MotionUnits.to_core`` when a segment of the program is placed on the cam, and the
  limits and objectives when they state their rows. The displacement of an arm is the arc of its
  roller's centre, a length: ``Travel.per_unit`` of it is one unit on the wire.
* core → wire: ``MotionUnits.to_wire``, ``Machine.wire_factor`` and ``Objective.to_wire``.
* wire → problem and back: ``optimise/problem/nondimensional.py``, which divides every field
  of a spec by the unit of length L (the longest travel of a segment) and of time T. The result is
  a spec again, so that every mm of ``catalogue`` is L throughout ``optimise``.
* problem → conic program: the larger of ``Problem.length`` and the least norm scales the size
  variables, ``PlacedSegment.scale`` the laws.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Final, Literal

DEGREE: Final = math.pi / 180.0  # rad
FULL_TURN: Final = 2.0 * math.pi  # rad
PER_MINUTE: Final = 60.0 / FULL_TURN  # rpm per rad/s
FIELD_SUFFIXES: Final = ("", "_per_s", "_per_s2", "_per_s3")
"""How a field name continues after mm or deg, by the order of the time derivative."""
SYMBOLS: Final = {"n": "N", "mpa": "MPa", "hz": "Hz"}  # of units that a field spells otherwise
_PLAIN = rf"(?:mm|deg|rad|rpm|kg|m|s|{'|'.join(SYMBOLS)})[23]?"
FIELD_UNIT: Final = re.compile(rf"_(?P<over>{_PLAIN}(?:_{_PLAIN})*?)(?:_per_(?P<under>{_PLAIN}))?$")


def split_unit(field: str) -> tuple[str, str]:
    """A field's name without its unit, and the unit: ``max`` and mm/s³ of ``max_mm_per_s3``."""
    match = FIELD_UNIT.search(field)
    if match is None:
        return field, ""
    words = " ".join(SYMBOLS.get(word, word) for word in match["over"].split("_"))
    unit = words if match["under"] is None else f"{words}/{match['under']}"
    return field[: match.start()], unit.translate(str.maketrans("23", "²³"))


def rad_per_s(speed_rpm: float) -> float:
    """Angular speed ω [rad/s] of a shaft turning at ``speed_rpm``."""
    return speed_rpm * FULL_TURN / 60.0


@dataclass(frozen=True)
class Travel:
    """The unit in which the wire gives a follower's displacement: mm, or deg of its arm.

    Attributes:
        unit: on the wire. per_unit: length in the core of one such unit [mm].
    """

    unit: Literal["mm", "deg"] = "mm"
    per_unit: float = 1.0

    def derivative_unit(self, order: int) -> str:
        """Unit of the ``order``-th time derivative, as in ``mm/s²``."""
        return self.unit + ("", "/s", "/s²", "/s³", "/s⁴")[order]

    def field_suffix(self, order: int) -> str:
        """The same as it ends the name of a field, as in ``mm_per_s2``; order at most 3."""
        return self.unit + FIELD_SUFFIXES[order]

    def wire_factor(self, order: int, omega: float) -> float:
        """Factor from s^(order) per radian to the time derivative on the wire, at ω [rad/s]."""
        return float(omega**order / self.per_unit)


MILLIMETRES: Final = Travel()


@dataclass(frozen=True)
class MotionUnits:
    """Conversion of displacements and their derivatives between the wire and the core.

    Attributes:
        travel: unit of the displacement on the wire. omega: cam speed ω [rad/s].
    """

    travel: Travel = MILLIMETRES
    omega: float = 1.0

    def to_core(self, value: float, order: int = 0) -> float:
        """s^(order) per radian [mm/rad^order] of a time derivative on the wire."""
        return value / self.travel.wire_factor(order, self.omega)

    def to_wire(self, value: float, order: int = 0) -> float:
        """The time derivative on the wire of s^(order) per radian."""
        return value * self.travel.wire_factor(order, self.omega)


CORE_UNITS: Final = MotionUnits()
"""Displacements in mm, derivatives per radian: the wire's numbers are the core's."""
