"""Numbers of the motion program, and the speed, of which a change may mend a conflict.

None of them can be left out, so they are no members of a conflict: they belong to what the cam has
to do. A change of one, with all limits as they are, is what an engineer may prefer.

    angle of a move     longer; the longest dwell gives the degrees
    lift                all lifts smaller, in proportion
    speed               lower, where a limit depends on it
    end of a range      farther, where the number that was chosen lies at it
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from synthesis.catalogue.fields import Range, ends
from synthesis.pipeline.relaxable import Relaxable
from synthesis.spec.design_spec import DesignSpec
from synthesis.spec.program import Dwell, Return, Rise

MOST = 0.5  # relative: larger changes of a program make another task of it
JERK = 3.0  # power with which jerk goes with the speed, and inversely with an angle
ROUNDING = 1e-12  # relative: of an angle that is given to another, what its difference is off by
AT_END = 1e-3  # of a range: a number so near to its end may want to lie beyond


@dataclass(frozen=True)
class ProgramNumber(Relaxable):
    """A number of the program; others change with it in proportion.

    Attributes:
        slopes: change of each number at ``paths`` per unit of the first one's.
    """

    slopes: tuple[float, ...] = (1.0,)

    @property
    def tightest(self) -> float:
        return self.requested[0]

    def values_at(self, value: float) -> Iterator[tuple[str, float, float]]:
        change = value - self.requested[0]
        for path, requested, slope in zip(self.paths, self.requested, self.slopes, strict=True):
            value = requested + slope * change
            # A dwell that gives all of its angle is left with rounding of it.
            yield path, requested, 0.0 if abs(value) < ROUNDING * abs(requested) else value


def program_numbers(spec: DesignSpec, chosen: Sequence[float]) -> Iterator[ProgramNumber]:
    """The numbers of a program whose change may mend a conflict.

    Args:
        spec: the question.
        chosen: numbers that were chosen for those that it leaves free, in their order.
    """
    yield from _angles(spec)
    yield from _lifts(spec)
    yield from _speed(spec)
    yield from _ends_of_ranges(spec, chosen)


def _angles(spec: DesignSpec) -> Iterator[ProgramNumber]:
    """Every move longer.

    A free law followed by a rest, or preceded by one, is a law of the longer move, and a dwell that
    loses degrees keeps its limits: where nothing else of the move is fixed to angles, a cam for an
    angle is one for all longer ones too.
    """
    segments = spec.program
    dwells = [
        (segment.degrees, i)
        for i, segment in enumerate(segments)
        if isinstance(segment, Dwell) and not segment.open and segment.degrees > 0.0
    ]
    if not dwells:
        return
    given, donor = max(dwells)
    for i, move in enumerate(segments):
        if not isinstance(move, Rise | Return) or isinstance(move.angle_deg, Range):
            continue
        beside = (segments[i - 1], segments[(i + 1) % len(segments)])
        rests = any(isinstance(segment, Dwell) for segment in beside)
        free = move.law.free_law() is not None and _is_plain(move)
        yield ProgramNumber(
            f"angle of program/{i}", (f"program/{i}/angle_deg", f"program/{donor}/angle_deg"),
            (move.degrees, given), "deg", "≤", power=JERK, slopes=(1.0, -1.0),
            monotone=free and rests and _eases_when_slower(spec),
            farthest=move.degrees + min(given, MOST * move.degrees),
        )  # fmt: skip


def _lifts(spec: DesignSpec) -> Iterator[ProgramNumber]:
    """All lifts smaller: other dimensions do not shrink with them, so nothing is proven so."""
    moves = [
        (i, segment) for i, segment in enumerate(spec.program) if not isinstance(segment, Dwell)
    ]
    paths, lifts = list[str](), list[float]()
    for i, move in moves:
        if not isinstance(move, Rise | Return) or not _is_plain(move):
            return
        low, high = ends(move.given("lift"))
        if low != high:
            return
        paths.append(f"program/{i}/{move.given_field('lift')}")
        lifts.append(low)
    first, *_ = lifts
    yield ProgramNumber(
        "all lifts", tuple(paths), tuple(lifts), spec.follower.travel.unit,
        "≥", slopes=tuple(lift / first for lift in lifts), monotone=False,
        farthest=(1.0 - MOST) * first,
    )  # fmt: skip


def _speed(spec: DesignSpec) -> Iterator[ProgramNumber]:
    """The speed lower, where a limit depends on it."""
    if all(limit.at_lower_speed == "same" for limit in spec.all_limits()):
        return
    moves = [segment for segment in spec.program if not isinstance(segment, Dwell)]
    if all(isinstance(move, Rise | Return) and _is_plain(move) for move in moves):
        yield ProgramNumber(
            "speed", ("speed_rpm",), (spec.speed_rpm,), "rpm", "≥", power=JERK,
            monotone=_eases_when_slower(spec), farthest=(1.0 - MOST) * spec.speed_rpm,
        )  # fmt: skip


def _ends_of_ranges(spec: DesignSpec, chosen: Sequence[float]) -> Iterator[ProgramNumber]:
    """Ends of ranges at which the numbers lie that were chosen; wider ranges exclude nothing."""
    for parameter, value in zip(spec.free_parameters.parameters, chosen, strict=False):
        low, high = ends(parameter.requested)
        if parameter.segment is None or not low < high:
            continue
        unit, name = parameter.name.rpartition("_")[2], parameter.field.replace("/", " ")
        if value >= high - AT_END * (high - low):
            yield ProgramNumber(
                f"largest {name}", (f"{parameter.field}/max",), (high,), unit, "≤",
                farthest=(1.0 + MOST) * high,
            )  # fmt: skip
        elif value <= low + AT_END * (high - low):
            yield ProgramNumber(
                f"least {name}", (f"{parameter.field}/min",), (low,), unit, "≥",
                farthest=(1.0 - MOST) * low,
            )  # fmt: skip


def _is_plain(move: Rise | Return) -> bool:
    """Whether no velocity, acceleration or place within a move is asked for."""
    return not (move.windows or move.points or move.start or move.end)


def _eases_when_slower(spec: DesignSpec) -> bool:
    """Whether no limit becomes harder for a motion that is slower, or rests for longer."""
    return spec.load is None and all(
        limit.at_lower_speed != "either" for limit in spec.all_limits()
    )
