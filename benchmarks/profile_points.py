"""1440 profile points with normals, curvature and pressure angle, for several kinds of motion."""

import numpy as np

from benchmarks.density import textbook
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, in_turns
from synthesis.catalogue.followers import TranslatingRoller
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.catalogue.profile import cam_profile
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Piecewise

POINTS = 1440
SIZE = (20.0, float(np.sqrt(60.0**2 - 20.0**2)))  # example 13-6
TEXT = "Position, normal, curvature and pressure angle of all points of one turn."
FOLLOWER = TranslatingRoller(roller_radius_mm=10.0, offset_mm=20.0)


def motion(rise: Piecewise, back: Piecewise) -> Motion:
    """Example 13-6's program with other laws: rise 60°, dwell 30°, return 60°, dwell 210°."""
    still = Piecewise.of([0.0, 1.0], [[0.0]])
    ends = np.radians([0.0, 60.0, 90.0, 150.0, 360.0])
    plan = (
        ("rise", 0.0, 30.0, rise),
        ("dwell", 30.0, 30.0, still),
        ("return", 30.0, 0.0, back),
        ("dwell", 0.0, 0.0, still),
    )
    return Motion.of(
        [
            PlacedSegment(i, kind, ends[i], ends[i + 1] - ends[i], low, high, law)
            for i, (kind, low, high, law) in enumerate(plan)
        ]
    )


def spline(degree: int, intervals: int) -> Piecewise:
    """A rising spline from rest to rest."""
    space = SplineSpace(degree, np.linspace(0.0, 1.0, intervals + 1))
    middle = np.linspace(0.0, 1.0, space.size - 4)[1:-1]
    return space.curve(np.concatenate([np.zeros(3), middle, np.ones(3)]))


def run(effort: Effort = FULL) -> Section:
    """Time for each kind of motion."""
    theta = np.radians(np.arange(POINTS) * 360.0 / POINTS)
    calls: dict[str, Call] = {
        name: (lambda m=moving: cam_profile(m, FOLLOWER, SIZE, "ccw", theta))
        for name, moving in motions().items()
    }
    times = in_turns(calls, effort.repeats(200), effort.warm_up(10))
    place, curvature = errors(6 if effort.trial else 120)
    rows = [(name, str(time)) for name, time in times.items()]
    slowest = max(times.values(), key=lambda time: time.median)
    reported = f"{place:.0e} mm, {curvature:.0e} of curvature"
    note = f"With the cycloidal law, against the textbook in forty digits: {reported} at most."
    table = Table(("motion of rise and return", ">time"), rows, note)
    front = (f"{POINTS} profile points with curvature, at most", str(slowest), reported)
    return Section(f"{POINTS} profile points", TEXT, [table], [front])


def errors(angles: int) -> tuple[float, float]:
    """Largest error of the cycloidal cam's places [mm] and curvature (of the largest)."""
    truth = textbook(angles)
    theta = np.radians(truth.degrees)
    found = cam_profile(motions()["cycloidal"], FOLLOWER, SIZE, "ccw", theta)
    away = np.hypot(found.x - truth.places[:, 0], found.y - truth.places[:, 1])
    bent = np.abs(1.0 / found.radius - truth.curvature) / np.max(np.abs(truth.curvature))
    return float(np.max(away)), float(np.max(bent))


def motions() -> dict[str, Motion]:
    """Example 13-6's program with several laws."""
    named = ("cycloidal", "modified_sine", "polynomial_4_5_6_7")
    cases = {name: LAWS[name].curve for name in named}
    found = {name: motion(law("rise"), law("return")) for name, law in cases.items()}
    for degree, intervals in ((3, 20), (5, 20), (5, 80)):
        law = spline(degree, intervals)
        found[f"spline, degree {degree}, {intervals} intervals"] = motion(law, law)
    return found
