"""Random everyday scenes by family: one row a combination of follower, laws, limits and objective.

Numbers come from fixed seeds and have three digits, none of them special. A new follower, limit or
objective joins by a row in ``FAMILIES``.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from math import pi
from types import MappingProxyType
from typing import Any

import numpy as np

Spec = dict[str, Any]
Random = np.random.Generator
SEED = 20_261_123
SPLINE: Spec = {"kind": "spline"}


def three_digits(value: float) -> float:
    return float(f"{value:.3g}")


class Scene:
    """Draws the numbers of one scene: speed, angles and lift first, then what a family asks for."""

    def __init__(self, family: str, number: int) -> None:
        self._random = np.random.default_rng([SEED, zlib.crc32(family.encode()), number])
        self.rpm = self.between(40.0, 300.0)
        self.rise, self.back = self.between(60.0, 125.0), self.between(60.0, 125.0)
        self.top = self.between(15.0, 50.0)
        self.lift, self.unit = self.between(8.0, 32.0), "mm"

    def between(self, low: float, high: float) -> float:
        return three_digits(self._random.uniform(low, high))

    def one_of(self, *items: Any) -> Any:
        return items[int(self._random.integers(len(items)))]

    # -- programs ----------------------------------------------------------------------------

    def program(self, law: Spec = SPLINE, back: Spec | None = None, **more: Any) -> list[Spec]:
        """Rise, dwell, return, dwell; ``more``: further fields of the rise."""
        lift = {f"lift_{self.unit}": self.lift}
        return [
            {"kind": "rise", "angle_deg": self.rise, **lift, "law": law, **more},
            {"kind": "dwell", "angle_deg": self.top},
            {"kind": "return", "angle_deg": self.back, **lift, "law": back or law},
            {"kind": "dwell", "angle_deg": round(360.0 - self.rise - self.top - self.back, 9)},
        ]

    def free_angles(self) -> list[Spec]:
        rise, top, back, low = self.program()
        for move in (rise, back):
            least = move["angle_deg"]
            move["angle_deg"] = {"min": three_digits(0.8 * least), "max": three_digits(1.4 * least)}
        return [rise, top, back, low]

    def two_steps(self) -> list[Spec]:
        """Two rises whose lifts are free, and one return."""
        _, top, back, low = self.program()
        share = {"min": three_digits(0.3 * self.lift), "max": three_digits(0.7 * self.lift)}
        half = round(0.5 * self.rise, 6)
        step = {"kind": "rise", "angle_deg": half, f"lift_{self.unit}": share, "law": SPLINE}
        return [step, dict(step), top, back, low]

    # -- limits ------------------------------------------------------------------------------

    def pressure(self, low: float = 27.0, high: float = 43.0) -> Spec:
        angles = {name: self.between(low, high) for name in ("rise_deg", "return_deg")}
        return {"kind": "pressure_angle", **angles}

    def peak(self, order: int, least: float, low: float = 1.15, high: float = 3.5) -> Spec:
        """A cap of ``low`` to ``high`` times the least that a law of the program needs."""
        speed = 6.0 * self.rpm  # degrees a second
        sharpest = self.lift * (speed / min(self.rise, self.back)) ** order
        cap = three_digits(sharpest * least * self.between(low, high))
        kind = {1: "velocity", 2: "acceleration", 3: "jerk"}[order]
        return {"kind": kind, f"max_{self.unit}_per_s{order if order > 1 else ''}": cap}

    def jerk(self, low: float = 1.15, high: float = 3.5) -> Spec:
        return self.peak(3, 32.0, low, high)

    # -- followers ---------------------------------------------------------------------------

    def roller(self, **more: Any) -> Spec:
        radius = self.between(5.0, 12.0)
        return {"kind": "translating_roller", "roller_radius_mm": radius, **more}

    def centred(self, **more: Any) -> Spec:
        return self.roller(offset_mm=0, **more)

    def arm(self, **more: Any) -> Spec:
        """A roller on an arm, its pivot free; the lift becomes a swing."""
        self._swing(12.0, 24.0)
        return {
            "kind": "oscillating_roller", "roller_radius_mm": self.between(5.0, 12.0),
            "arm_mm": self.between(65.0, 115.0), "sense": self.one_of("same", "opposite"), **more,
        }  # fmt: skip

    def pivoted(self, **more: Any) -> Spec:
        arm = self.arm(**more)
        return {**arm, "centre_distance_mm": three_digits(arm["arm_mm"] * self.between(1.05, 1.3))}

    def swinging_face(self, **more: Any) -> Spec:
        self._swing(8.0, 16.0)
        return {
            "kind": "oscillating_flat_face", "centre_distance_mm": self.between(80.0, 130.0),
            "face_offset_mm": self.between(0.0, 6.0), "sense": self.one_of("same", "opposite"),
            **more,
        }  # fmt: skip

    def _swing(self, low: float, high: float) -> None:
        self.lift, self.unit = self.between(low, high), "deg"

    # -- the whole ---------------------------------------------------------------------------

    def spec(self, follower: Spec, limits: list[Spec], program: list[Spec] | None = None,
             **more: Any) -> Spec:  # fmt: skip
        return {
            "speed_rpm": self.rpm,
            "program": self.program() if program is None else program,
            "follower": follower,
            "limits": limits,
            "tolerance": 0.005,
            **more,
        }


def _smooth(k: int) -> Spec:
    return {"kind": "spline", "smoothness": k}


def _named(kind: str) -> Spec:
    return {"kind": kind}


def _roller_spec(*limits: Callable[[Scene], Spec], **more: Any) -> Callable[[Scene], Spec]:
    return lambda s: s.spec(s.roller(), [s.pressure(), *(limit(s) for limit in limits)], **more)


def _jerk(s: Scene) -> Spec:
    return s.jerk()


def _velocity(s: Scene) -> Spec:
    return s.peak(1, 2.0, 0.8, 1.2)


def _acceleration(s: Scene) -> Spec:
    return s.peak(2, 4.0, 1.15, 2.0)


def _acceleration_and_jerk(s: Scene) -> list[Spec]:
    return [s.peak(2, 5.0, 1.15, 2.0), s.jerk()]


def _radius(s: Scene) -> Spec:
    return {"kind": "profile_radius", "min_mm": s.between(2.0, 7.0)}


def _loaded(*limits: Spec) -> Callable[[Scene], Spec]:
    def make(s: Scene) -> Spec:
        speed = pi * s.rpm / 30.0
        inertia = 1e-3 * s.lift * speed * speed * (180.0 / min(s.rise, s.back)) ** 2  # N per kg
        load = {
            "kind": "slide", "moving_mass_kg": s.between(0.5, 2.0),
            "spring": {"rate_n_per_mm": s.between(1.0, 5.0),
                       "preload_n": three_digits(60.0 + inertia * s.between(2.0, 4.0))},
            "contact": {"width_mm": s.between(8.0, 14.0)},
        }  # fmt: skip
        return s.spec(s.roller(), [s.pressure(), s.jerk(), *limits], load=load)

    return make


def _sized(objective: str) -> Callable[[Scene], Spec]:
    """Another objective: what ends the cam's growth is part of the question."""

    def make(s: Scene) -> Spec:
        angle = [] if objective == "peak_pressure_angle" else [s.pressure()]
        radius = {"max": three_digits(s.lift * s.between(2.0, 4.0))}
        return s.spec(
            s.centred(), [*angle, s.jerk()], base_radius_mm=radius, objective={"kind": objective}
        )

    return make


def _then(objective: str) -> Callable[[Scene], Spec]:
    both = [{"kind": "base_radius"}, {"kind": objective}]
    return _roller_spec(_jerk, objective=both)


def _arm_with(*limits: Callable[[Scene], Spec], pivot: bool = True) -> Callable[[Scene], Spec]:
    def make(s: Scene) -> Spec:
        follower = s.pivoted() if pivot else s.arm()
        return s.spec(follower, [s.pressure(33.0, 44.0), *(limit(s) for limit in limits)])

    return make


def _face_with(law: Spec, *limits: Callable[[Scene], Spec], **more: Any) -> Callable[[Scene], Spec]:
    def make(s: Scene) -> Spec:
        follower = s.swinging_face(**more)
        return s.spec(follower, [_radius(s), *(limit(s) for limit in limits)], s.program(law))

    return make


def _in_groove(s: Scene) -> Spec:
    groove = {"kind": "groove", "clearance_mm": 0.05, "rim_mm": s.between(5.0, 9.0)}
    return s.spec(s.roller(closure=groove), [s.pressure(), s.jerk()])


def _in_ring(s: Scene) -> Spec:
    ring = {"kind": "force", "contact": "inside", "rim_mm": s.between(4.0, 8.0)}
    return s.spec(s.roller(closure=ring), [s.pressure(), s.jerk(), _radius(s)])


def _conjugate(s: Scene) -> Spec:
    follower = s.centred()
    counter = {"kind": "conjugate", "roller_radius_mm": follower["roller_radius_mm"],
               "offset_mm": 0}  # fmt: skip
    return s.spec({**follower, "closure": counter}, [s.pressure(), s.jerk(), _radius(s)])


def _conjugate_arms(s: Scene) -> Spec:
    follower = s.pivoted(sense="same")
    counter = {"kind": "conjugate", "roller_radius_mm": follower["roller_radius_mm"],
               "arm_mm": follower["arm_mm"]}  # fmt: skip
    return s.spec({**follower, "closure": counter}, [s.pressure(33.0, 44.0), s.jerk()])


def _arm_grooved(s: Scene) -> Spec:
    groove = {"kind": "groove", "clearance_mm": 0.05, "rim_mm": s.between(5.0, 9.0)}
    return s.spec(s.pivoted(closure=groove), [s.pressure(33.0, 44.0), s.jerk()])


def _pivot_in_range(s: Scene) -> Spec:
    arm = s.arm()
    near, far = (three_digits(arm["arm_mm"] * share) for share in (0.9, 1.35))
    arm["centre_distance_mm"] = {"min": near, "max": far}
    return s.spec(arm, [s.pressure(33.0, 44.0), s.jerk()])


def _arm_free(s: Scene) -> Spec:
    arm = s.pivoted()
    low, high = (three_digits(arm["arm_mm"] * share) for share in (0.7, 1.2))
    given = s.program(_named("modified_sine"))
    return s.spec({**arm, "arm_mm": {"min": low, "max": high}}, [s.pressure(36.0, 46.0)], given)


def _arm_given(pivot: bool) -> Callable[[Scene], Spec]:
    def make(s: Scene) -> Spec:
        arm = s.pivoted() if pivot else s.arm()
        return s.spec(arm, [s.pressure(36.0, 46.0)], s.program(_named("polynomial_3_4_5")))

    return make


def _windowed(s: Scene) -> Spec:
    at = round(0.4 * s.rise, 3), round(0.6 * s.rise, 3)
    mean = s.lift * 6.0 * s.rpm / s.rise
    window = {"from_deg": at[0], "to_deg": at[1],
              "velocity_mm_per_s": {"max": three_digits(1.5 * mean)}}  # fmt: skip
    return s.spec(s.roller(), [s.pressure(), s.jerk(2.0, 4.0)], s.program(windows=[window]))


def _quiet(s: Scene) -> Spec:
    rest = {"kind": "residual_vibration", "natural_frequency_hz": three_digits(s.rpm / 60.0 * 9.0),
            "max_mm": three_digits(0.002 * s.lift)}  # fmt: skip
    return s.spec(s.roller(), [s.pressure(), s.jerk(2.0, 4.0), rest])


def _face(law: Spec, *limits: Callable[[Scene], Spec], **more: Any) -> Callable[[Scene], Spec]:
    def make(s: Scene) -> Spec:
        follower = {"kind": "translating_flat_face", **more}
        return s.spec(follower, [_radius(s), *(limit(s) for limit in limits)], s.program(law))

    return make


FAMILIES: Mapping[str, Callable[[Scene], Spec]] = MappingProxyType({
    # a roller on a slide
    "slide, centred": lambda s: s.spec(s.centred(), [s.pressure(), s.jerk()]),
    "slide, offset given": lambda s: s.spec(
        s.roller(offset_mm=s.between(-6.0, 6.0)), [s.pressure(), s.jerk()]),
    "slide, offset free": _roller_spec(_jerk),
    "slide, offset in a range": lambda s: s.spec(
        s.roller(offset_mm={"min": -s.between(3.0, 18.0), "max": s.between(3.0, 18.0)}),
        [s.pressure(), s.jerk()]),
    "slide, splines of class C3": lambda s: s.spec(
        s.roller(), [s.pressure(), s.jerk()], s.program(_smooth(3))),
    "slide, splines of class C4": lambda s: s.spec(
        s.roller(), [s.pressure(), s.jerk()], s.program(_smooth(4))),
    "slide, laws given": lambda s: s.spec(
        s.roller(), [s.pressure()], s.program(_named("modified_sine"))),
    "slide, laws given, centred": lambda s: s.spec(
        s.centred(), [s.pressure()], s.program(_named("cycloidal"))),
    "slide, one law given": lambda s: s.spec(
        s.roller(), [s.pressure(), s.jerk()], s.program(SPLINE, _named("polynomial_4_5_6_7"))),
    "slide, laws given, profile radius": lambda s: s.spec(
        s.roller(), [s.pressure(), _radius(s)], s.program(_named("modified_sine"))),
    "slide, profile radius": _roller_spec(_jerk, _radius),
    "slide, acceleration": _roller_spec(_acceleration),
    "slide, acceleration and profile radius": _roller_spec(_acceleration, _radius),
    "slide, acceleration, splines of class C3": lambda s: s.spec(
        s.roller(), [s.pressure(), _acceleration(s)], s.program(_smooth(3))),
    "slide, velocity, acceleration and jerk": lambda s: s.spec(
        s.roller(), [s.pressure(), _velocity(s), *_acceleration_and_jerk(s)]),
    "slide, all three, splines of class C3": lambda s: s.spec(
        s.roller(), [s.pressure(), _velocity(s), *_acceleration_and_jerk(s)],
        s.program(_smooth(3))),
    "slide, outer radius": _roller_spec(
        _jerk, lambda s: {"kind": "outer_radius", "max_mm": three_digits(8.0 * s.lift)}),
    "slide, cutter radius": _roller_spec(
        _jerk, lambda s: {"kind": "cutter_radius", "radius_mm": s.between(15.0, 60.0)}),
    "slide, window": _windowed,
    "slide, residual vibration": _quiet,
    "slide, angles free": lambda s: s.spec(
        s.centred(), [s.pressure(), s.jerk()], s.free_angles()),
    "slide, lifts free": lambda s: s.spec(s.centred(), [s.pressure(), s.jerk(10.0, 20.0)],
                                          s.two_steps()),
    "slide, groove": _in_groove,
    "slide, ring": _in_ring,
    "slide, conjugate": _conjugate,
    "slide, contact force": _loaded({"kind": "contact_force", "min_n": 0}),
    "slide, Hertz pressure": _loaded({"kind": "hertz_pressure", "max_mpa": 900}),
    # other objectives
    "slide, then peak jerk": _then("peak_jerk"),
    "slide, then rms acceleration": _then("rms_acceleration"),
    "slide, peak acceleration": _sized("peak_acceleration"),
    "slide, rms jerk": _sized("rms_jerk"),
    "slide, peak pressure angle": _sized("peak_pressure_angle"),
    # a flat face on a slide
    "face, laws free": _face(SPLINE, _jerk),
    "face, laws given": _face(_named("cycloidal")),
    "face, width": _face(SPLINE, _jerk, lambda s: {
        "kind": "face_width", "width_mm": three_digits(2.8 * s.lift * 57.3 / min(s.rise, s.back)
                                                       * 2.0)}),
    "face, tilted": _face(SPLINE, _jerk, tilt_deg=12.3, offset_mm=-9.7),
    # a roller on an arm
    "arm, pivot given": _arm_with(_jerk),
    "arm, pivot free": _arm_with(_jerk, pivot=False),
    "arm, pivot in a range": _pivot_in_range,
    "arm, profile radius": _arm_with(_jerk, _radius),
    "arm, length free": _arm_free,
    "arm, laws given": _arm_given(pivot=True),
    "arm, laws given, pivot free": _arm_given(pivot=False),
    "arm, groove": _arm_grooved,
    "arm, conjugate": _conjugate_arms,
    # a flat face on a pivot
    "swinging face, laws free": _face_with(SPLINE, _jerk),
    "swinging face, laws given": _face_with(_named("modified_sine")),
    "swinging face, pivot in a range": _face_with(
        _named("cycloidal"), centre_distance_mm={"min": 61.3, "max": 131.0}),
})  # fmt: skip


def _face_pivot_in_range(s: Scene) -> Spec:
    face = s.swinging_face()
    near, far = (three_digits(face["centre_distance_mm"] * share) for share in (0.8, 1.3))
    return s.spec({**face, "centre_distance_mm": {"min": near, "max": far}}, [_radius(s)])


# No objective is named, and no limit speaks of acceleration or jerk: the rms jerk is held within an
# allowance, then the cam is made small. Apart from the others, whose scenes are numbered in turn.
DEFAULT_OBJECTIVES: Mapping[str, Callable[[Scene], Spec]] = MappingProxyType({
    "no objective, slide": _roller_spec(),
    "no objective, slide, profile radius": _roller_spec(_radius),
    "no objective, face": _face(SPLINE),
    "no objective, face, tilted": _face(SPLINE, tilt_deg=12.3, offset_mm=-9.7),
    "no objective, arm": _arm_with(),
    "no objective, arm, pivot free": _arm_with(pivot=False),
    "no objective, arm, groove": lambda s: _without(_arm_grooved(s), "jerk"),
    "no objective, arm, conjugate": lambda s: _without(_conjugate_arms(s), "jerk"),
    "no objective, swinging face": _face_with(SPLINE),
    "no objective, swinging face, pivot in a range": _face_pivot_in_range,
})  # fmt: skip


def _without(spec: Spec, kind: str) -> Spec:
    """A spec without its limits of a kind."""
    return {**spec, "limits": [limit for limit in spec["limits"] if limit["kind"] != kind]}


def random_scene(family: str, number: int) -> Spec:
    """The scene of a family and a number, the same at every call."""
    make = FAMILIES.get(family) or DEFAULT_OBJECTIVES[family]
    return make(Scene(family, number))
