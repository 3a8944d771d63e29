"""Wrong input: each a 4xx problem document that names field, value, rule and way out."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from typing import Any

import httpx2
import pytest

from service.wire import validation
from synthesis.errors.violations import describe_errors
from tests.service.specs import spec

Change = Callable[[dict[str, Any]], None]


def changed(**fields: Any) -> Change:
    return lambda body: body.update(fields)


def segment(index: int, **fields: Any) -> Change:
    return lambda body: body["program"][index].update(fields)


def table(*rows: list[Any]) -> Change:
    fields = {"kind": "table", "angle_deg": 60, "tolerance_mm": 0.01, "points": list(rows)}
    return lambda body: body["program"].__setitem__(0, fields)


def follower(**fields: Any) -> Change:
    return lambda body: body["follower"].update(fields)


def without(*path: str | int) -> Change:
    def change(body: Any) -> None:
        for part in path[:-1]:
            body = body[part]
        del body[path[-1]]

    return change


def on_an_arm(swing: float = 45.0, base: float = 80.0, **fields: Any) -> Change:
    """The same program with an arm of 85 mm, its pivot 100 mm away, a roller of 30 mm."""

    def change(body: Any) -> None:
        for part in body["program"]:
            if part.pop("lift_mm", None) is not None:
                part["lift_deg"] = swing
        body["follower"] = {
            "kind": "oscillating_roller", "arm_mm": 85, "centre_distance_mm": 100,
            "roller_radius_mm": 30, **fields,
        }  # fmt: skip
        body.update(base_radius_mm=base, limits=[])

    return change


def on_a_face(swing: float = 10.0, base: float = 40.0, **fields: Any) -> Change:
    """The same program with a flat face on a pivot 60 mm away, its laws given."""

    def change(body: Any) -> None:
        for part in body["program"]:
            if part.pop("lift_mm", None) is not None:
                part.update(lift_deg=swing, law={"kind": "cycloidal"})
        body["follower"] = {"kind": "oscillating_flat_face", "centre_distance_mm": 60, **fields}
        body.update(base_radius_mm=base, limits=[])

    return change


# what is changed, where the caller is pointed to, what is said there
TABLE: dict[str, tuple[Change, str, Any, str]] = {
    "angles do not sum": (segment(3, angle_deg=200), "/program", 350.0, "Add 10°"),
    "lift does not return": (segment(2, lift_mm=20), "/program", 10.0, "sum to zero"),
    "never moves": (
        changed(program=[{"kind": "dwell", "angle_deg": 360}]), "/program", None, "Add both",
    ),
    "no program": (without("program"), "/program", None, "Segments in order"),
    "empty program": (changed(program=[]), "/program", [], "at least 1"),
    "too many segments": (
        changed(program=[{"kind": "dwell", "angle_deg": 1}] * 5000), "/program", ..., "at most 100",
    ),
    "negative angle": (segment(0, angle_deg=-60), "/program/0/angle_deg", -60, "greater than 0"),
    "negative lift": (segment(0, lift_mm=-30), "/program/0/lift_mm", -30, "must be positive"),
    "lift is text": (segment(0, lift_mm="30"), "/program/0/lift_mm", "30", "must be a number"),
    "lift is true": (segment(0, lift_mm=True), "/program/0/lift_mm", True, "must be a number"),
    "a law that is text": (
        segment(0, law="cycloidal"), "/program/0/law", "cycloidal", 'Write {"kind": "cycloidal"}',
    ),
    "an angle limit without angles": (
        changed(limits=[{"kind": "pressure_angle"}]), "/limits/0", None, "Give rise_deg",
    ),
    "lift missing": (without("program", 0, "lift_mm"), "/program/0", None, "no lift"),
    "two lifts": (segment(0, lift_deg=20), "/program/0", None, "two lifts"),
    "an angle for a slide": (
        segment(0, lift_mm=None, lift_deg=20), "/program/0", ..., "Give lift_mm instead",
    ),
    "a length for an arm": (
        follower(kind="oscillating_roller", arm_mm=85, centre_distance_mm=100), "/program/0", ...,
        "Give lift_deg instead",
    ),
    "an arm that is too short": (
        on_an_arm(arm_mm=10, base=90), "/follower", 10, "reaches radii from 90 to 110",
    ),
    "an arm that is too short, where": (
        on_an_arm(arm_mm=10, base=90), "/follower", 10, "at cam angle 0.0° (program/0)",
    ),
    "an arm that is too short at its longest": (
        on_an_arm(arm_mm={"min": 5, "max": 11}, base=90), "/follower/arm_mm", 5, "Widen its range",
    ),
    "an arm between ends the wrong way round": (
        on_an_arm(arm_mm={"min": 95, "max": 85}), "/follower/arm_mm", ..., "Exchange the two",
    ),
    "an arm with one end": (
        on_an_arm(arm_mm={"min": 95}), "/follower/arm_mm/max", None, "Largest length allowed",
    ),
    "an arm that is too long": (on_an_arm(arm_mm=250), "/follower", 250, "from 150 to 350"),
    "a roller over its own pivot": (
        on_an_arm(swing=20, arm_mm=25, base=60), "/follower/arm_mm", 25, "Take a longer arm",
    ),
    "a swing past the line of centres": (
        on_an_arm(swing=120), "/program", pytest.approx(107.545951),
        "at cam angle 44.2529° (program/0)",
    ),
    "an angle that contradicts the radius": (
        on_an_arm(initial_angle_deg=60), "/follower/initial_angle_deg", 60, "Leave out one",
    ),
    "an angle that is none": (
        on_an_arm(initial_angle_deg=190), "/follower/initial_angle_deg", 190, "0° and 180°",
    ),
    "a face that turns with the cam": (
        on_a_face(swing=45), "/program", 1.5, "turn the sense",
    ),
    "a face past the right angle": (
        on_a_face(base=59.5), "/follower/centre_distance_mm", ..., "the centre distance larger",
    ),
    "a face whose pivot may be anywhere": (
        on_a_face(centre_distance_mm={"min": 50}), "/follower/centre_distance_mm", ...,
        "a range with a positive max",
    ),
    "a tilt that is none": (
        follower(kind="translating_flat_face", tilt_deg=1e-5), "/follower/tilt_deg", 1e-5, "Give 0",
    ),
    "a pivot on the axis": (
        on_an_arm(centre_distance_mm=0), "/follower/centre_distance_mm", 0, "positive",
    ),
    "absurd number": (segment(0, lift_mm=1e300), "/program/0/lift_mm", 1e300, "at most"),
    "huge integer": (segment(0, lift_mm=10**400), "/program/0/lift_mm", ..., "must be"),
    "a groove for a knife edge": (
        follower(roller_radius_mm=0, closure={"kind": "groove"}), "/follower/roller_radius_mm", 0,
        "Give the roller a radius",
    ),
    "a ring that the roller fills": (
        lambda body: (
            body.update(base_radius_mm=9),
            body["follower"].update(closure={"kind": "force", "contact": "inside"}),
        ), "/base_radius_mm", 9, "fill the ring",
    ),
    "a rim without a ring": (
        follower(closure={"kind": "force", "rim_mm": 4}), "/follower/closure/rim_mm", 4,
        "choose contact inside",
    ),
    "an unknown closure": (
        follower(closure={"kind": "grove"}), "/follower/closure/kind", "grove",
        "Did you mean 'groove'?",
    ),
    "a clearance below nothing": (
        follower(closure={"kind": "groove", "clearance_mm": -1}),
        "/follower/closure/clearance_mm", -1, "at least 0",
    ),
    "a counter cam that there is not": (
        changed(limits=[{"kind": "counter_base_radius", "min_mm": 40}]), "/limits", ...,
        "Remove it",
    ),
    "face of a roller": (
        changed(limits=[{"kind": "face_width", "width_mm": 40}]), "/limits", ..., "Remove it",
    ),
    "face of no width": (
        changed(
            follower={"kind": "translating_flat_face"}, limits=[{"kind": "face_width"}]
        ), "/limits/0", ..., "Give width_mm",
    ),
    "angle of a face": (
        changed(
            follower={"kind": "translating_flat_face"}, limits=[],
            objective={"kind": "peak_pressure_angle"},
        ), "/objective", ..., "another objective",
    ),
    "window after the segment": (
        segment(0, windows=[{"from_deg": 1, "to_deg": 99, "travel_mm": 3}]), "/program/0", 99.0,
        "split the window",
    ),
    "one free angle": (
        segment(0, angle_deg={"min": 50, "max": 70}), "/program/0/angle_deg", ...,
        "another one free",
    ),
    "free angles that cannot fit": (
        lambda body: segment(0, angle_deg={"min": 50, "max": 59})(body)
        or segment(2, angle_deg={"min": 50, "max": 60})(body),
        "/program", ..., "Widen a range",
    ),
    "free angle without an end": (
        segment(0, angle_deg={"min": 50}), "/program/0/angle_deg/max", None, "required",
    ),
    "window of nothing": (
        segment(0, windows=[{"from_deg": 1, "to_deg": 9}]), "/program/0/windows/0", ...,
        "travel_mm",
    ),
    "point before the segment": (
        segment(0, points=[{"angle_deg": 0, "travel_mm": 3}]), "/program/0", 0.0, "lift_mm",
    ),
    "window on a dwell": (
        segment(1, windows=[]), "/program/1/windows", [], "not a field",
    ),
    "unknown segment": (segment(0, kind="ris"), "/program/0/kind", "ris", "Did you mean 'rise'"),
    "segment of no kind": (without("program", 1, "kind"), "/program/1/kind", None, "required"),
    "segment is a number": (changed(program=[3]), "/program/0", 3, "object"),
    "unknown law": (
        segment(0, law={"kind": "cycloid"}), "/program/0/law/kind", "cycloid", 'Write "cycloidal"',
    ),
    "parts of a law too long": (
        segment(0, law={"kind": "scca", "b": 0.5, "c": 0.5, "d": 0.5}), "/program/0/law", 1.5,
        "Scale the parts down",
    ),
    "part of a law too short": (
        segment(0, law={"kind": "scca", "b": 1e-6}), "/program/0/law", 1e-6, "at least 0.001",
    ),
    "a state that the law has not": (
        segment(2, start={"acceleration_mm_per_s2": 7}), "/program/2/start", 7.0, "polynomial_5",
    ),
    "a state of nothing known": (
        segment(0, end={"speed": 3}), "/program/0/end/speed", 3, "velocity_mm_per_s",
    ),
    "a spline sent backwards": (
        segment(0, law={"kind": "spline"}, end={"velocity_mm_per_s": -5}), "/program/0", -5.0,
        "overshoot",
    ),
    "constant velocity of no size": (
        segment(1, kind="constant_velocity"), "/program/1", 0, "exactly one",
    ),
    "a table out of order": (
        table([0, 1], [20, 3], [20, 9], [40, 19], [60, 31]), "/program/0", 20.0, "Remove one",
    ),
    "a table with a hole": (
        table([0, 1], [20, 3], [30, None], [60, 31]), "/program/0/points/2/1", None, "number",
    ),
    "a table of columns that differ": (
        lambda body: table()(body) or segment(
            0, points=None, angles_deg=[0, 60], displacements_mm=[0]
        )(body),
        "/program/0", 2, "as many of one",
    ),
    "a table of no tolerance": (
        lambda body: table([0, 0], [20, 3], [40, 9], [60, 30])(body) or segment(
            0, tolerance_mm=None
        )(body), "/program/0", None, "Give tolerance_mm",
    ),
    "a state in the wrong unit": (
        segment(0, end={"velocity_deg_per_s": 3.0}), "/program/0", None, "all in deg",
    ),
    "a straight line in the wrong unit": (
        lambda body: body["program"].__setitem__(
            0, {"kind": "constant_velocity", "angle_deg": 60, "lift_deg": 30}
        ), "/program/0", ..., "lift_mm",
    ),
    "continuity of a fifth derivative": (changed(continuity=5), "/continuity", 5, "3, 4"),
    "unknown follower": (follower(kind="flat"), "/follower/kind", "flat", "translating_roller"),
    "negative roller": (
        follower(roller_radius_mm=-1), "/follower/roller_radius_mm", -1, "at least 0",
    ),
    "misspelt field": (
        follower(roler_radius_mm=1), "/follower/roler_radius_mm", 1,
        "Did you mean 'roller_radius_mm'",
    ),
    "no follower": (without("follower"), "/follower", None, "required"),
    "offset beyond prime radius": (
        lambda body: body.update(base_radius_mm=20) or follower(offset_mm=50)(body),
        "/follower/offset_mm", 50.0, "smaller offset",
    ),
    "negative base radius": (changed(base_radius_mm=-5), "/base_radius_mm", -5.0, "positive"),
    "base radius is text": (changed(base_radius_mm="x"), "/base_radius_mm", "x", "number"),
    "base radius range empty": (
        changed(base_radius_mm={"min": 3, "max": 1}), "/base_radius_mm", ..., "Exchange",
    ),
    "base radius misspelt": (
        changed(base_radius_mm={"minimum": 3}), "/base_radius_mm/minimum", 3, 'Write "min": 3',
    ),
    "unknown limit": (
        changed(limits=[{"kind": "jrk"}]), "/limits/0/kind", "jrk", "Did you mean 'jerk'",
    ),
    "limit without its bound": (
        changed(limits=[{"kind": "jerk"}]), "/limits/0", None, "no limit",
    ),
    "limit with two bounds": (
        changed(limits=[{"kind": "jerk", "max_mm_per_s3": 1e6, "max_deg_per_s3": 1e5}]),
        "/limits/0", None, "two limits",
    ),
    "limit in the unit of an arm": (
        changed(limits=[{"kind": "velocity", "max_deg_per_s": 100}]), "/limits/0", ..., "deg",
    ),
    "pressure angle of 90°": (
        changed(limits=[{"kind": "pressure_angle", "rise_deg": 90}]), "/limits/0/rise_deg", 90,
        "less than 90",
    ),
    "unknown objective": (
        changed(objective={"kind": "cost"}), "/objective/kind", "cost", "base_radius",
    ),
    "unknown second objective": (
        changed(objective=[{"kind": "base_radius"}, {"kind": "peak_jerks"}]), "/objective/1/kind",
        "peak_jerks", "'peak_jerk'",
    ),
    "unknown field": (changed(speed=3), "/speed", 3, '"speed_rpm" is given already'),
    "standing still": (changed(speed_rpm=0), "/speed_rpm", 0, "positive"),
    "wrong sense": (changed(rotation="left"), "/rotation", "left", "ccw"),
    "no tolerance left": (changed(tolerance=0), "/tolerance", 0, "positive"),
    "a name without end": (changed(name="x" * 300), "/name", ..., "at most 200"),
    "a field with a slash": (changed(**{"a/b~c": 1}), "/a~1b~0c", 1, "not a field"),
}  # fmt: skip


@pytest.mark.parametrize(("change", "pointer", "value", "words"), TABLE.values(), ids=TABLE.keys())
def test_a_design_that_makes_no_sense(
    client: httpx2.Client, change: Change, pointer: str, value: Any, words: str
) -> None:
    body = spec()
    change(body)
    answer = client.post("/v1/designs", json=body)
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    found = [entry for entry in problem["errors"] if entry["pointer"] == pointer]
    assert len(found) == 1, problem["errors"]
    if value is not ...:
        assert found[0]["value"] == value
    assert words in f"{found[0]['rule']} {found[0]['remedy']}"
    assert found[0]["rule"] in problem["detail"] or len(problem["errors"]) > 1
    assert len(answer.content) < 5000


def post(client: httpx2.Client, content: Any, kind: str | None = "application/json") -> Any:
    headers = {} if kind is None else {"Content-Type": kind}
    answer = client.post("/v1/designs", content=content, headers=headers)
    assert answer.headers["content-type"] == "application/problem+json", answer.text
    problem = answer.json()
    assert problem["status"] == answer.status_code
    assert len(problem["detail"]) > 20
    return problem


@pytest.mark.parametrize("word", ["NaN", "Infinity", "-Infinity"])
def test_words_that_are_no_numbers(client: httpx2.Client, word: str) -> None:
    text = json.dumps(spec()).replace('"lift_mm": 30', f'"lift_mm": {word}', 1)
    problem = post(client, text)
    assert problem["status"] == 422
    assert problem["errors"] == [
        {
            "pointer": "/program/0/lift_mm",
            "value": word,
            "rule": "must be a finite number; JSON does not have this word",
            "remedy": "Give a number, or leave the field out where it may be missing.",
        }
    ]


def test_a_number_beyond_all_numbers(client: httpx2.Client) -> None:
    problem = post(client, json.dumps(spec()).replace('"lift_mm": 30', '"lift_mm": 1e400', 1))
    assert problem["errors"][0]["pointer"] == "/program/0/lift_mm"
    assert problem["errors"][0]["value"] == "Infinity"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"   ", "empty"),
        (b'{"program": [', "Line 1, column"),
        (b"{'program': 1}", "Line 1, column 2"),
        (b"{\"program\": 'x'}", "JSON has double quotes"),
        (b'{"limits": [1, ]}', "Leave out the comma before it."),
        (b'{"report_smoothness_cost": True}', "JSON writes true, false and null."),
        (b'{"tolerance": .5}', "0.5"),
        (b'{"speed_rpm": 60 // slow\n}', "JSON has no comments."),
        (b'{"a": "\xff\xfe"}', "UTF-8"),
        (b"[" * 100_000 + b"]" * 100_000, "nested"),
        (b'{"a":' * 50_000 + b"1" + b"}" * 50_000, "nested"),
        (b'{"name": "a", "name": "b"}', "'name' occurs twice"),
        (b'{"name": ' + b"9" * 10_000 + b"}", "digits"),
    ],
    ids=[
        "nothing",
        "blanks",
        "cut off",
        "quotes",
        "quotes of a text",
        "comma",
        "Python",
        "point",
        "comment",
        "bytes",
        "lists",
        "objects",
        "twice",
        "digits",
    ],
)
def test_what_is_not_json(client: httpx2.Client, content: bytes, words: str) -> None:
    problem = post(client, content)
    assert problem["status"] == 400
    assert words in problem["detail"]


@pytest.mark.parametrize("text", ['{"a": [1 , ]}', '{"a": 1,\n}'])
def test_a_comma_too_many_is_told_wherever_reading_ends(text: str) -> None:
    """Before Python 3.13 at the bracket behind it, since then at the comma itself."""
    bracket = max(text.find("]"), 0) or text.index("}")
    for end in (text.index(","), bracket):
        error = json.JSONDecodeError("Illegal trailing comma", text, end)
        assert validation._in_json(error) == "Leave out the comma before it."
    none = json.JSONDecodeError("Expecting value", '{"a": , 1}', 6)
    assert validation._in_json(none) == "Send valid JSON."


@pytest.mark.parametrize("content", [b"[]", b"3", b"null", b'"text"'])
def test_json_that_is_no_object(client: httpx2.Client, content: bytes) -> None:
    problem = post(client, content)
    assert problem["status"] == 422
    assert problem["errors"][0]["pointer"] == ""
    assert "object" in problem["errors"][0]["rule"]


@pytest.mark.parametrize("kind", [None, "text/plain", "application/x-www-form-urlencoded", "json"])
def test_another_media_type(client: httpx2.Client, kind: str | None) -> None:
    assert post(client, json.dumps(spec()).encode(), kind)["status"] == 415


def test_ten_megabytes_with_their_length(client: httpx2.Client) -> None:
    problem = post(client, b'{"name": "' + b"x" * 10_000_000 + b'"}')
    assert (problem["status"], problem["type"]) == (413, "/problems/body-too-large")
    assert "1048576 bytes" in problem["detail"]


def test_ten_megabytes_in_pieces(client: httpx2.Client) -> None:
    def pieces() -> Iterator[bytes]:
        yield b'{"name": "'
        for _ in range(1000):
            yield b"x" * 10_000

    assert post(client, pieces())["status"] == 413


@pytest.mark.parametrize(
    ("name", "remedy"), [("cycloids", "Did you mean 'cycloidal'?"), ("xyz", "Choose one of these.")]
)
def test_the_kinds_that_there_are_are_listed_once(
    client: httpx2.Client, name: str, remedy: str
) -> None:
    body = spec()
    segment(0, law={"kind": name})(body)
    problem = client.post("/v1/designs", json=body).json()
    assert problem["detail"].count("kloomok_muffley_8") == 1
    assert problem["detail"].endswith(remedy)


def test_values_with_full_stops_do_not_part_a_message() -> None:
    """The core says "Rule. What to do."; a name of the caller may look like that."""
    value = "No. 1. of two"
    error = {"type": "of_the_core", "loc": (), "ctx": {"value": value}, "input": None}
    message = f"{value} is taken. Take another one. Or none."
    (found,), _ = describe_errors([{**error, "msg": message}], {}, None)
    assert (found["rule"], found["remedy"]) == (f"{value} is taken.", "Take another one. Or none.")
