"""Wrong requests of people who have not read the manual, and what the first error must say.

A request is an example with changes: a pointer and its new value; ``GONE`` takes a field away, and
``Named`` gives it another name and perhaps another value.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

from service.contract.examples import examples

GONE = object()
SAME = object()


@dataclass(frozen=True)
class Named:
    """Another name of a field, and its value: the field's own where it is left out."""

    name: str
    value: Any = SAME


PUSHER: dict[str, Any] = {
    "speed_rpm": 200,
    "program": [
        {"kind": "rise", "angle_deg": 120, "lift_mm": 45},
        {"kind": "dwell", "angle_deg": 60},
        {"kind": "return", "angle_deg": 100, "lift_mm": 45},
        {"kind": "dwell", "angle_deg": 80},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 16},
    "limits": [{"kind": "pressure_angle", "rise_deg": 30, "return_deg": 30}],
}
BASES: dict[str, tuple[str, dict[str, Any]]] = {
    "designs": ("/v1/designs", PUSHER),
    "sweeps": ("/v1/sweeps", examples("sweeps")["pressure-angle-and-jerk"]["value"]),
    "analyses": ("/v1/analyses", examples("analyses")["p3-same"]["value"]),
    "cam sets": ("/v1/cam-sets", examples("cam-sets")["p3-set"]["value"]),
    "spatial cams": ("/v1/spatial-cams", examples("spatial-cams")["cylindrical-sized"]["value"]),
    "trains": ("/v1/train-responses", examples("train-responses")["press-feeder"]["value"]),
    "shapers": (
        "/v1/linkages/six-bar-shapers", examples("linkages/six-bar-shapers")["sized"]["value"],
    ),
    "arms": (
        "/v1/linkages/palletising-arms", examples("linkages/palletising-arms")["irb-660"]["value"],
    ),
    "measured": ("/v1/profile-analyses", examples("profile-analyses")["spare-roller"]["value"]),
}  # fmt: skip


@dataclass(frozen=True)
class WrongRequest:
    """A wrong request: of which resource, how it differs, the first error's place and words.

    ``count``: how many errors are told.
    """

    base: str
    changes: dict[str, Any]
    pointer: str
    words: tuple[str, ...]
    count: int = 1

    @property
    def path(self) -> str:
        """Where it is posted."""
        return BASES[self.base][0]

    @property
    def body(self) -> Any:
        """The body, changed."""
        body = copy.deepcopy(BASES[self.base][1])
        for pointer, value in self.changes.items():
            if not pointer:
                return value(body) if callable(value) else value
            *above, last = pointer[1:].split("/")
            holder: Any = body
            for part in above:
                holder = holder[int(part) if isinstance(holder, list) else part]
            key: Any = int(last) if isinstance(holder, list) else last
            if value is GONE:
                del holder[key]
            elif isinstance(value, Named):
                old = holder.pop(key)
                holder[value.name] = old if value.value is SAME else value.value
            else:
                holder[key] = value
        return body


def wrong(
    base: str, changes: dict[str, Any], pointer: str, *words: str, count: int = 1
) -> WrongRequest:
    """A wrong request."""
    return WrongRequest(base, changes, pointer, words, count)


D = "designs"
REQUESTS: dict[str, WrongRequest] = {
    # Names of other books, and other units.
    "the roller's diameter": wrong(
        D, {"/follower/roller_radius_mm": Named("roller_diameter_mm", 32)},
        "/follower/roller_diameter_mm", 'Write "roller_radius_mm": 16', "half of the diameter",
    ),
    "the roller's diameter, short": wrong(
        D, {"/follower/roller_radius_mm": Named("rollerDia", 32)},
        "/follower/rollerDia", 'Write "roller_radius_mm": 16', "half",
    ),
    "Ø with the number": wrong(
        D, {"/follower/roller_radius_mm": "Ø32"},
        "/follower/roller_radius_mm", "Write 16",
    ),
    "lift without its unit": wrong(
        D, {"/program/0/lift_mm": Named("lift")}, "/program/0/lift", 'Write "lift_mm": 45.',
    ),
    "stroke": wrong(
        D, {"/program/0/lift_mm": Named("stroke")}, "/program/0/stroke", 'Write "lift_mm": 45.',
    ),
    "h": wrong(D, {"/program/0/lift_mm": Named("h")}, "/program/0/h", 'Write "lift_mm": 45.'),
    "the stroke in inches": wrong(
        D, {"/program/0/lift_mm": Named("stroke_in", 0.75)},
        "/program/0/stroke_in", 'Write "lift_mm": 19.05', "0.75 in", count=2,
    ),
    "the lift in metres": wrong(
        D, {"/program/0/lift_mm": Named("lift_m", 0.045)},
        "/program/0/lift_m", 'Write "lift_mm": 45',
    ),
    "rpm": wrong(D, {"/speed_rpm": Named("rpm")}, "/rpm", 'Write "speed_rpm": 200.'),
    "omega": wrong(
        D, {"/speed_rpm": Named("omega_rad_per_s", 20.94)},
        "/omega_rad_per_s", 'Write "speed_rpm": 200', "20.94",
    ),
    "cam speed in Hz": wrong(
        D, {"/speed_rpm": Named("camSpeedHz", 2)}, "/camSpeedHz", 'Write "speed_rpm": 120',
    ),
    "beta": wrong(
        D, {"/program/0/angle_deg": Named("beta")}, "/program/0/beta", 'Write "angle_deg": 120.',
    ),
    "angle": wrong(
        D, {"/program/0/angle_deg": Named("angle")}, "/program/0/angle", 'Write "angle_deg": 120.',
    ),
    "cam angle in radians": wrong(
        D, {"/program/0/angle_deg": Named("cam_angle_rad", 2.0944)},
        "/program/0/cam_angle_rad", 'Write "angle_deg": 120', "2.0944 rad",
    ),
    "German names": wrong(
        D,
        {"/program/0/lift_mm": Named("hub"), "/program/0/angle_deg": Named("winkel"),
         "/speed_rpm": Named("drehzahl"), "/follower/exzentrizität": 5},
        "/program/0/hub", 'Write "lift_mm": 45.', count=4,
    ),
    "Grundkreisdurchmesser": wrong(
        D, {"/Grundkreisdurchmesser": 80}, "/Grundkreisdurchmesser", 'Write "base_radius_mm": 40',
    ),
    "base circle": wrong(
        D, {"/base_circle_mm": 40}, "/base_circle_mm", 'Write "base_radius_mm": 40.',
    ),
    "a bore": wrong(
        D, {"/bore_in": 1, "/base_radius_mm": 60}, "/bore_in",
        'Write "shaft_diameter_mm": 25.4 (1 in).',
    ),
    "the prime radius": wrong(
        D, {"/prime_radius_mm": 56}, "/prime_radius_mm", "as 56 less the roller's radius",
    ),
    "the roller at the top": wrong(
        D, {"/follower/roller_radius_mm": GONE, "/roller_radius_mm": 16},
        "/roller_radius_mm", '"follower": {"roller_radius_mm": 16}',
    ),
    "eccentricity at the top": wrong(
        D, {"/eccentricity_mm": 5}, "/eccentricity_mm", '"follower": {"offset_mm": 5}',
    ),
    "the lift at the top": wrong(
        D, {"/lift_mm": 45}, "/lift_mm", "each entry of program",
    ),
    "pressure angle at the top": wrong(
        D, {"/pressure_angle_max": 30, "/limits": GONE}, "/pressure_angle_max",
        '"limits": [{"kind": "pressure_angle"', '"rise_deg"',
    ),
    "one pressure angle": wrong(
        D, {"/limits/0": {"kind": "pressure_angle", "max_deg": 30}}, "/limits/0/max_deg",
        'Write "rise_deg": 30', '"return_deg": 30',
    ),
    "max acceleration": wrong(
        D, {"/base_radius_mm": 40, "/limits/0": {"kind": "acceleration", "max": 50000}},
        "/limits/0/max", 'Write "max_mm_per_s2": 50000',
    ),
    "acceleration in m/s²": wrong(
        D, {"/base_radius_mm": 40, "/limits/0": {"kind": "acceleration", "max_m_per_s2": 50}},
        "/limits/0/max_m_per_s2", 'Write "max_mm_per_s2": 50000',
    ),
    "acceleration in g": wrong(
        D, {"/base_radius_mm": 40, "/limits/0": {"kind": "acceleration", "max_g": 5}},
        "/limits/0/max_g", 'Write "max_mm_per_s2": 49033.25',
    ),
    "segments": wrong(
        D, {"/program": Named("segments")}, "/segments", 'Write "program" instead of "segments"',
    ),
    "type": wrong(
        D, {"/program/0/kind": Named("type")}, "/program/0/type", 'Write "kind": "rise"',
    ),
    "a follower type": wrong(
        D, {"/follower": GONE, "/follower_type": "translating_roller"},
        "/follower_type", '"follower"', '"kind": "translating_roller"', count=...,
    ),
    "the whole in an envelope": wrong(
        D, {"": lambda body: {"spec": body}}, "/spec", "without \"spec\" around it",
    ),
    "units as a field": wrong(D, {"/units": "inch"}, "/units", "25.4 mm"),
    # Kinds by other words.
    "fall": wrong(
        D, {"/program/2/kind": "fall"}, "/program/2/kind", 'Write "return".',
    ),
    "return_": wrong(
        D, {"/program/2/kind": "return_"}, "/program/2/kind", 'Write "return".',
    ),
    "Rast": wrong(D, {"/program/1/kind": "Rast"}, "/program/1/kind", 'Write "dwell".'),
    "cycloid": wrong(
        D, {"/program/0/law": {"kind": "cycloid"}}, "/program/0/law/kind", 'Write "cycloidal".',
    ),
    "mod sine": wrong(
        D, {"/program/0/law": {"kind": "mod_sine"}}, "/program/0/law/kind",
        'Write "modified_sine".',
    ),
    "3-4-5": wrong(
        D, {"/program/0/law": "3-4-5"}, "/program/0/law", '{"kind": "polynomial_3_4_5"}',
    ),
    "geneigte Sinuslinie": wrong(
        D, {"/program/0/law": {"kind": "geneigte Sinuslinie"}}, "/program/0/law/kind",
        'Write "cycloidal".',
    ),
    "a knife edge": wrong(
        D, {"/follower/kind": "knife_edge"}, "/follower/kind", 'Write "translating_roller"',
        '"roller_radius_mm": 0',
    ),
    "a swinging arm": wrong(
        D, {"/follower/kind": "swinging_roller"}, "/follower/kind", 'Write "oscillating_roller"',
        count=...,
    ),
    "clockwise": wrong(D, {"/rotation": "clockwise"}, "/rotation", 'Write "cw".'),
    "no kind": wrong(
        D, {"/program/1/kind": GONE}, "/program/1/kind", 'Add "kind": "dwell"',
    ),
    "no kind of a move": wrong(
        D, {"/program/0/kind": GONE}, "/program/0/kind", '"rise"', '"return"',
    ),
    # Values.
    "a negative lift": wrong(
        D, {"/program/2": {"kind": "rise", "angle_deg": 100, "lift_mm": -45}},
        "/program/2/lift_mm", '"kind": "return" with "lift_mm": 45',
    ),
    "a negative return": wrong(
        D, {"/program/2/lift_mm": -45}, "/program/2/lift_mm", "Write 45",
    ),
    "a lift of zero": wrong(
        D, {"/program/0/lift_mm": 0}, "/program/0/lift_mm", "dwell",
    ),
    "a dwell with a lift": wrong(
        D, {"/program/1/lift_mm": 0}, "/program/1/lift_mm", "a dwell has no lift",
    ),
    "both ends of a range": wrong(
        D, {"/base_radius_min": 40, "/base_radius_max": 60}, "/base_radius_min",
        'Write "base_radius_mm": {"min": 40, "max": 60}.', count=2,
    ),
    "a text with its unit": wrong(
        D, {"/program/0/lift_mm": "45 mm"}, "/program/0/lift_mm", "Write 45", "without a unit",
    ),
    "a text in inches": wrong(
        D, {"/program/0/lift_mm": '3/4"'}, "/program/0/lift_mm", "Write 19.05", count=2,
    ),
    "a decimal comma": wrong(
        D, {"/program/0/lift_mm": "45,5", "/program/2/lift_mm": 45.5},
        "/program/0/lift_mm", "Write 45.5",
    ),
    "a number in quotes": wrong(D, {"/speed_rpm": "200"}, "/speed_rpm", "Write 200", "quotes"),
    "a number in a list": wrong(D, {"/speed_rpm": [200]}, "/speed_rpm", "Write 200"),
    "value and unit": wrong(
        D, {"/speed_rpm": {"value": 200, "unit": "rpm"}}, "/speed_rpm", "Write 200",
    ),
    "words for a number": wrong(D, {"/speed_rpm": "fast"}, "/speed_rpm", "without a unit"),
    "a range as a list": wrong(
        D, {"/base_radius_mm": [40, 60]}, "/base_radius_mm", '{"min": 40, "max": 60}',
    ),
    "one limit without a list": wrong(
        D, {"/limits": {"kind": "pressure_angle", "rise_deg": 30}}, "/limits", "brackets",
    ),
    "limits by name": wrong(
        D, {"/limits": {"pressure_angle": 30}}, "/limits", '[{"kind": "pressure_angle"',
    ),
    "segments as numbers": wrong(
        D, {"/program": [120, 60, 100, 80]}, "/program/0", '"kind"', "rise", count=4,
    ),
    "the body in quotes": wrong(D, {"": "{}"}, "", "not as a text in quotes"),
    "a list of requests": wrong(
        D, {"": lambda body: [body, body]}, "", "/v1/sweeps",
    ),
    # A field in the wrong object, and a kind in the wrong field.
    "the closure's kind as a contact": wrong(
        D, {"/follower/contact": "groove"}, "/follower/contact",
        'Write "closure": {"kind": "groove"}.',
    ),
    "the closure's contact in the follower": wrong(
        D, {"/follower/contact": "inside"}, "/follower/contact",
        'into follower/closure: "closure": {"kind": "force", "contact": "inside"}.',
    ),
    "a closure as a switch": wrong(
        D, {"/follower/force_closed": True}, "/follower/force_closed",
        'Write "closure": {"kind": "force"}.',
    ),
    "a closure as an object of its name": wrong(
        D, {"/follower/rainure": {"rim_mm": 10}}, "/follower/rainure",
        'Write "closure": {"kind": "groove", …}.',
    ),
    "a spring in the follower": wrong(
        D, {"/follower/spring": {"rate": 5}}, "/follower/spring",
        'Write it into load: "load": {"spring": …}.',
    ),
    "friction as a number in the follower": wrong(
        D, {"/follower/friction": 0.1}, "/follower/friction",
        'Write it into load: "load": {"kind": "slide", "friction": {…}}, with "coefficient"',
    ),
    "a coefficient of friction at the top": wrong(
        D, {"/mu": 0.12}, "/mu", '"friction": {"coefficient": 0.12, "overhang_mm": …}',
    ),
    "a law at the top": wrong(
        D, {"/motion_curve": "cycloidal"}, "/motion_curve",
        'into each entry of program: "law": {"kind": "cycloidal", …}.',
    ),
    "the speed in a segment": wrong(
        D, {"/speed_rpm": GONE, "/program/0/rpm": 200}, "/program/0/rpm",
        'Write it into the request itself: "speed_rpm": 200.',
    ),
    "a bound in a segment": wrong(
        D, {"/program/0/max_acceleration_mm_per_s2": 5000},
        "/program/0/max_acceleration_mm_per_s2", '"limits": [{"kind": "acceleration", …}]',
    ),
    "a bound in the objective": wrong(
        D, {"/objective": {"kind": "base_radius", "max_pressure_angle": 30}},
        "/objective/max_pressure_angle", '"limits": [{"kind": "pressure_angle", …}]',
    ),
    "a part of the request in an object": wrong(
        D, {"/speed_rpm": GONE, "/cam": {"base_radius_mm": 40, "speed_rpm": 200}}, "/cam",
        'Send what is in "cam" beside the others, without "cam" around it.',
    ),
    "a velocity limit for both signs": wrong(
        D, {"/base_radius_mm": 40, "/limits/0": {"kind": "velocity", "min": -500, "max": 500}},
        "/limits/0/min", "Remove it: the limit holds for both signs.", count=2,
    ),
    "positions of a segment's ends": wrong(
        D, {"/program/0/start_mm": 0, "/program/0/end_mm": 45}, "/program/0/start_mm",
        'write "lift_mm"', count=2,
    ),
    "angles of a segment's ends": wrong(
        D, {"/program/1/start_deg": 120, "/program/0/start_deg": 0}, "/program/0/start_deg",
        'write "angle_deg"', count=2,
    ),
    "an end that many fields have": wrong(
        D, {"/limits/0": {"kind": "outer_radius", "max_mm": 200, "min": 10}}, "/limits/0/min",
        "Allowed: kind, max_mm.",
    ),
    "materials beside the contact": wrong(
        D, {"/load": {"kind": "slide", "moving_mass_kg": 2, "material": "steel"}},
        "/load/material", 'write them into "contact"', count=...,
    ),
    "gravity in a load": wrong(
        D, {"/load": {"kind": "slide", "moving_mass_kg": 2, "gravity": 9.81}},
        "/load/gravity", '"rise_from_vertical_deg"', count=...,
    ),
    "an arm's sizes by letters": wrong(
        D,
        {"/follower": {"kind": "oscillating_roller", "roller_radius_mm": 16, "arm_mm": 100,
                       "center": 120, "phi0": 20},
         "/program/0/lift_mm": Named("lift_deg", 20), "/program/2/lift_mm": Named("lift_deg", 20)},
        "/follower/center", 'Write "centre_distance_mm": 120.', count=...,
    ),
    "French names": wrong(
        D,
        {"/speed_rpm": Named("vitesse"), "/program/0/lift_mm": Named("levée"),
         "/follower/roller_radius_mm": Named("rayon du galet")},
        "/program/0/levée", 'Write "lift_mm": 45.', count=3,
    ),
    "French kinds": wrong(D, {"/program/0/kind": "montée"}, "/program/0/kind", 'Write "rise".'),
    "Bestehorn-Sinoide": wrong(
        D, {"/program/0/law": "Bestehorn-Sinoide"}, "/program/0/law", '{"kind": "cycloidal"}',
    ),
    "a spring's rate in N/m": wrong(
        D,
        {"/load": {"kind": "slide", "moving_mass_kg": 2,
                   "spring": {"rate_n_per_m": 5000, "preload_n": 100}}},
        "/load/spring/rate_n_per_m", 'Write "rate_n_per_mm": 5 (5000 N/m).',
    ),
    "a jerk in m/s³": wrong(
        D, {"/base_radius_mm": 40, "/limits/0": {"kind": "jerk", "max_m_s3": 5000}},
        "/limits/0/max_m_s3", 'Write "max_mm_per_s3": 5000000 (5000 m/s³).',
    ),
    "a mixed number of inches": wrong(
        D, {"/program/0/lift_mm": "1 3/4 in", "/program/2/lift_mm": 44.45},
        "/program/0/lift_mm", "Write 44.45 (1 3/4 in in mm)",
    ),
    "commas between thousands": wrong(
        D, {"/speed_rpm": "1,200.0"}, "/speed_rpm", "Write 1200, without quotes.",
    ),
    "an angle by π": wrong(
        D, {"/program/0/angle_deg": "2π/3"}, "/program/0/angle_deg", "its unit is deg",
    ),
    "a program by names": wrong(
        D, {"/program": {"rise": {"angle_deg": 180}, "dwell2": {"angle_deg": 180}}}, "/program",
        '[{"kind": "rise", …}, …]',
    ),
    "a segment as a list": wrong(
        D, {"/program/0": ["rise", 120, 45]}, "/program/0",
        'Write {"kind": "rise", "angle_deg": …}', count=...,
    ),
    "limits as a number": wrong(D, {"/limits": 30}, "/limits", "The kinds are pressure_angle"),
    "null for a kind": wrong(
        D, {"/program/0/kind": None}, "/program/0/kind", "one of rise", count=...,
    ),
    "a time in place of an angle": wrong(
        D, {"/program/0/angle_deg": Named("time_s", 0.1)}, "/program/0/time_s",
        'Write "angle_deg": the degrees that the cam turns in that time', count=2,
    ),
    "weights of objectives": wrong(
        D, {"/objective": {"base_radius": 0.5, "jerk": 0.5}}, "/objective/base_radius",
        'Write "kind": "base_radius"', count=2,
    ),
    "a second objective in the first": wrong(
        D, {"/objective": {"kind": "base_radius", "rms_jerk": 0.5}}, "/objective/rms_jerk",
        'Write a list, the most important first: [{"kind": "base_radius"}, {"kind": "rms_jerk"}].',
    ),
    "a sweep's step": wrong(
        "sweeps",
        {"/axes/0": {"kind": "range", "pointer": "/speed_rpm", "start": 1, "stop": 2, "step": 1}},
        "/axes/0/step", 'Write "count"', count=...,
    ),
    "a sweep's pointer with dots": wrong(
        "sweeps", {"/axes/0/pointer": "limits[0].rise_deg"}, "/axes/0/pointer",
        "Write /limits/0/rise_deg.",
    ),
    "a phase in the cam's spec": wrong(
        "cam sets", {"/cams/0/spec/phase_deg": 30}, "/cams/0/spec/phase_deg",
        'Write it into cams/0: "phase_deg": 30.',
    ),
    "radii as a measured profile": wrong(
        "measured", {"/points_mm": [30, 31]}, "/points_mm/0",
        "Write 2 numbers in brackets: […, …].", count=...,
    ),
    # Sums.
    "angles of 340°": wrong(
        D, {"/program/3/angle_deg": 60}, "/program", "Add 20°",
        "write 80 instead of 60 at program/3/angle_deg",
    ),
    "angles in radians": wrong(
        D, {"/program/0/angle_deg": 2.0944, "/program/1/angle_deg": 1.0472,
            "/program/2/angle_deg": 1.7453, "/program/3/angle_deg": 1.3963,
            "/limits/0/rise_deg": 0.5236, "/limits/0/return_deg": 0.5236},
        "/program", "radians", "Write 120 instead of 2.0944",
    ),
    "angles as parts of a turn": wrong(
        D, {"/program/0/angle_deg": 0.25, "/program/1/angle_deg": 0.25,
            "/program/2/angle_deg": 0.25, "/program/3/angle_deg": 0.25},
        "/program", "turn", "Write 90 instead of 0.25",
    ),
    "it does not come back": wrong(
        D, {"/program/2/lift_mm": 40}, "/program", "Write 45 instead of 40 at program/2/lift_mm",
    ),
    "no return": wrong(
        D, {"/program/2": {"kind": "dwell", "angle_deg": 100}}, "/program",
        '"kind": "return"', '"lift_mm": 45',
    ),
    # Causes before consequences.
    "several names at once": wrong(
        D, {"/program": Named("segments"), "/follower": Named("tappet"), "/speed_rpm": "200 rpm"},
        "/segments", "program", count=3,
    ),
    "a name hides a sum": wrong(
        D, {"/program/0/angle_deg": Named("beta", 100)},
        "/program/0/beta", 'Write "angle_deg": 100.', count=2,
    ),
    # Other resources.
    "a sweep of a spec": wrong(
        "sweeps", {"/base": Named("spec")}, "/spec", 'Write "base" instead of "spec"',
    ),
    "a sweep's axis by a path": wrong(
        "sweeps", {"/axes/0/pointer": Named("parameter")}, "/axes/0/parameter", 'Write "pointer"',
    ),
    "a sweep by linspace": wrong(
        "sweeps", {"/axes/0/kind": "linspace"}, "/axes/0/kind", 'Write "range".',
    ),
    "a sweep's axis from, to": wrong(
        "sweeps", {"/axes/0/start": Named("from"), "/axes/0/stop": Named("to")},
        "/axes/0/from", 'Write "start": 25.', count=2,
    ),
    "a sweep's pointer by another name": wrong(
        "sweeps", {"/axes/0/pointer": "/program/0/stroke"}, "/axes/0/pointer",
        "Write /program/0/lift_mm.",
    ),
    "a sweep's pointer without its stroke": wrong(
        "sweeps", {"/axes/0/pointer": "limits/0/rise_deg"}, "/axes/0/pointer",
        "Write /limits/0/rise_deg.",
    ),
    "a lift within a sweep": wrong(
        "sweeps", {"/base/program/0/lift_mm": Named("stroke_inch", 1)},
        "/base/program/0/stroke_inch", 'Write "lift_mm": 25.4', count=2,
    ),
    "an analysis of an arm in mm": wrong(
        "analyses", {"/follower/arm_mm": Named("lever_length_cm", 8.5)},
        "/follower/lever_length_cm", 'Write "arm_mm": 85',
    ),
    "a swing without its unit": wrong(
        "analyses", {"/program/0/lift_deg": Named("swing")}, "/program/0/swing",
        'Write "lift_deg": 45',
    ),
    "a distance of centres": wrong(
        "analyses", {"/follower/centre_distance_mm": Named("center_distance")},
        "/follower/center_distance", 'Write "centre_distance_mm": 100',
    ),
    "a phase in a cam set": wrong(
        "cam sets", {"/cams/1/phase_deg": Named("phase_angle")}, "/cams/1/phase_angle",
        'Write "phase_deg": 60.',
    ),
    "a cam set of designs": wrong(
        "cam sets", {"/cams/0/spec": Named("design")}, "/cams/0/design",
        'Write "spec" instead of "design"',
    ),
    "a barrel cam": wrong(
        "spatial cams", {"/machine/kind": "barrel"}, "/machine/kind",
        'Write "cylindrical_translating".',
    ),
    "a spatial cam's follower": wrong(
        "spatial cams", {"/machine": Named("follower")}, "/follower",
        'Write "machine" instead of "follower"',
    ),
    "a spatial pressure angle": wrong(
        "spatial cams", {"/limits/0/max_deg": "35°"}, "/limits/0/max_deg", "Write 35",
    ),
    "a mass in grams": wrong(
        "trains", {"/train/masses/0/mass_kg": Named("mass_g", 300)}, "/train/masses/0/mass_g",
        'Write "mass_kg": 0.3',
    ),
    "a spring rate k": wrong(
        "trains", {"/train/masses/0/stiffness_n_per_mm": Named("k")}, "/train/masses/0/k",
        'Write "stiffness_n_per_mm": 160',
    ),
    "a shaper's time ratio": wrong(
        "shapers", {"/quick_return_ratio": Named("time_ratio")}, "/time_ratio",
        'Write "quick_return_ratio": 1.8',
    ),
    "a shaper's crank by its radius": wrong(
        "shapers", {"/crank_mm": Named("crank_radius")}, "/crank_radius", '"crank_mm"',
    ),
    "a shaper's range as a list": wrong(
        "shapers", {"/crank_mm": [60, 250]}, "/crank_mm", '{"min": 60, "max": 250}',
    ),
    "a payload in pounds": wrong(
        "arms", {"/payload_kg": Named("payload_lb", 551)}, "/payload_lb", 'Write "payload_kg": 249',
    ),
    "a pose without its kind": wrong(
        "arms", {"/poses/1/kind": GONE}, "/poses/1/kind", 'Add "kind": "point"',
    ),
    "an arm in metres": wrong(
        "arms", {"/forearm_mm": Named("forearm_m", 1.35)}, "/forearm_m", 'Write "forearm_mm": 1350',
    ),
    "a measured profile's points": wrong(
        "measured", {"/points_mm": Named("profile")}, "/profile", 'Write "points_mm" instead',
    ),
    # What a second look at such answers found: fields of other kinds, nothing for a number, shares.
    "the radius of a roller that there is not": wrong(
        D, {"/follower/kind": "translating_flat_face"}, "/follower/roller_radius_mm",
        'Remove it: "kind": "translating_flat_face" has no roller_radius_mm',
        'Or write "kind": "translating_roller" or "oscillating_roller", which has it.',
    ),
    "an offset of a follower that swings": wrong(
        D, {"/follower": {"kind": "oscillating_roller", "roller_radius_mm": 16, "arm_mm": 100,
                          "centre_distance_mm": 120, "offset_mm": 3}},
        "/follower/offset_mm", 'Remove it: "kind": "oscillating_roller" has no offset_mm',
        '"translating_roller" or "translating_flat_face", which has it.',
    ),
    "an arm's length of a slide": wrong(
        D, {"/follower/arm_mm": 100}, "/follower/arm_mm",
        'Remove it: "kind": "translating_roller" has no arm_mm.', '"kind": "oscillating_roller"',
    ),
    "an inertia of a slide": wrong(
        D, {"/load": {"kind": "slide", "moving_mass_kg": 1, "moment_of_inertia_kg_m2": 0.1}},
        "/load/moment_of_inertia_kg_m2", 'Or write "kind": "arm", which has it.',
    ),
    "a pressure angle in another limit": wrong(
        D, {"/limits/0": {"kind": "jerk", "max_mm_per_s3": 1e6, "rise_deg": 30}},
        "/limits/0/rise_deg", 'Or write "kind": "pressure_angle", which has it.',
    ),
    "where a dwell starts": wrong(
        D, {"/program/1": {"kind": "dwell", "start_deg": 120, "end_deg": 180}},
        "/program/1/start_deg", 'Segments follow each other: write "angle_deg"', count=3,
    ),
    "no radius of a roller": wrong(
        D, {"/follower/roller_radius_mm": None},
        "/follower/roller_radius_mm", "Give a number. Radius",
    ),
    "no program": wrong(
        D, {"/program": None}, "/program", "Write a list of objects", "rise, dwell",
    ),
    "a base radius that is to be found": wrong(
        D, {"/base_radius_mm": "auto"}, "/base_radius_mm", "Leave it out, or give a number.",
    ),
    "a tolerance in per cent": wrong(D, {"/tolerance": "1%"}, "/tolerance", "Write 0.01 (1%), "),
    "a tolerance that is called one in per cent": wrong(
        D, {"/tolerance_percent": 1}, "/tolerance_percent", 'Write "tolerance": 0.01',
    ),
    "per cent of what has a unit": wrong(
        D, {"/program/0/angle_deg": "33 %"},
        "/program/0/angle_deg", "Give a number", "its unit is deg",
    ),
    "a stiffness in kN/mm": wrong(
        "trains", {"/train/masses/0/stiffness_n_per_mm": "2 kN/mm"},
        "/train/masses/0/stiffness_n_per_mm", "Write 2000 (2 kN/mm in N/mm)",
    ),
}  # fmt: skip
