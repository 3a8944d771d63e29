"""Bodies of up to 1 MiB that are made to cost time, each with the path that it is sent to.

They are used by tests and by ``python -m tests.service.wire.hostile``, which measures how long
others wait meanwhile.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from itertools import cycle, islice
from typing import Any

from tests.service.specs import CAM

LARGEST = 1_048_576  # bytes: the default limit of a body
DESIGNS, SWEEPS, SETS = "/v1/designs", "/v1/sweeps", "/v1/cam-sets"
MEASURED, TRAINS = "/v1/profile-analyses", "/v1/train-responses"
ROLLER = CAM["follower"]


def cam(**fields: Any) -> dict[str, Any]:
    """A valid spec, with other fields."""
    return {**CAM, **fields}


def full(before: str, entry: str, after: str) -> str:
    """A text with as many entries as fit."""
    count = (LARGEST - len(before) - len(after)) // (len(entry.encode()) + 1)
    return before + ",".join([entry] * count) + after


def names(count: int) -> dict[str, int]:
    """Names that no field has."""
    return {f"name_{i}": 1 for i in range(count)}


def around(body: Any, pattern: str) -> str:
    """A body with one text in it, "@", filled up to the limit."""
    text = json.dumps(body)
    room = (LARGEST - len(text)) // len(pattern.encode())
    return text.replace("@", pattern * room)


def moves(count: int, **fields: Any) -> list[dict[str, Any]]:
    """A program of rises and returns."""
    each = {"angle_deg": 360 / count, "lift_mm": 5, **fields}
    return list(islice(cycle([{"kind": "rise", **each}, {"kind": "return", **each}]), count))


def table(rows: int, angle: float = 360.0) -> dict[str, Any]:
    """A segment with a table that goes up and down."""
    points = [[round(angle * i / rows, 4), (i % 97) / 10] for i in range(rows)]
    points[-1] = [angle, 0.0]
    return {"kind": "table", "angle_deg": angle, "tolerance_mm": 1e-4, "points": points}


def swept(**fields: Any) -> dict[str, Any]:
    """A sweep, with other fields."""
    axis = {"kind": "list", "pointer": "/limits/0/rise_deg", "values": [30, 31]}
    return {"base": cam(), "axes": [axis], **fields}


def windows() -> list[dict[str, Any]]:
    """As many windows as a segment takes, all over each other."""
    return [
        {"from_deg": 0.01 * i, "to_deg": 3.0, "travel_mm": {"min": -1 - i, "max": 50 + i}}
        for i in range(50)
    ]


def linked() -> dict[str, Any]:
    """A sweep of as many fields as can be linked."""
    program = moves(100)
    fields = [f"/program/{i}/{name}" for i in range(100) for name in ("angle_deg", "lift_mm")]
    deep = [f"{field}{'/0' * (i % 40)}" for i, field in enumerate(fields)]
    axes = [
        {"kind": "list", "pointer": fields[-1 - n], "values": [3], "linked_pointers": deep[:100]}
        for n in range(20)
    ]
    return swept(base=cam(program=program), axes=axes)


def separate() -> dict[str, Any]:
    """A sweep that sets nearly every field of a long program, each once."""
    program = [{**each, "law": {"kind": "spline", "degree": 5}} for each in moves(100)]
    names = ("angle_deg", "lift_mm", "law")
    fields = [f"/program/{i}/{name}" for i in range(100) for name in names]
    axes = [
        {"kind": "list", "pointer": fields[15 * n], "values": [3],
         "linked_pointers": fields[15 * n + 1 : 15 * n + 15]}
        for n in range(20)
    ]  # fmt: skip
    return swept(base=cam(program=program), axes=axes)


def on_lists(value: Any) -> dict[str, Any]:
    """A sweep whose values are such a value, as many as fit."""
    size = len(json.dumps(value)) + 2
    values = [value] * min((LARGEST - 4000) // size, 100_000)
    return swept(axes=[{"kind": "list", "pointer": "/limits/0/rise_deg", "values": values}])


def dumped(make: Callable[[], Any]) -> Callable[[], str]:
    """The text of what a function makes."""
    return lambda: json.dumps(make())


BODIES: dict[str, tuple[str, Callable[[], str | bytes]]] = {
    # What is no JSON, or hardly.
    "nested lists": (DESIGNS, lambda: "[" * (LARGEST // 2) + "]" * (LARGEST // 2)),
    "nested lists without end": (DESIGNS, lambda: "[" * LARGEST),
    "nested objects": (DESIGNS, lambda: '{"a":' * (LARGEST // 6) + "1" + "}" * (LARGEST // 6)),
    "deep lists side by side": (DESIGNS, lambda: full("[", "[" * 400 + "]" * 400, "]")),
    "garbage behind": (DESIGNS, lambda: json.dumps(cam()) + "x" * (LARGEST - 1000)),
    "blanks behind": (DESIGNS, lambda: json.dumps(cam()) + " " * (LARGEST - 1000)),
    "lines before an error": (DESIGNS, lambda: "\n" * (LARGEST - 1) + "x"),
    "an end that is missing": (DESIGNS, lambda: '{"name":"' + "a" * (LARGEST - 9)),
    "nothing but NUL": (DESIGNS, lambda: b"\0" * LARGEST),
    "NUL in a text": (DESIGNS, lambda: around(cam(name="@"), "\\u0000")),
    "lone surrogates": (DESIGNS, lambda: around(cam(name="@"), "\\ud800")),
    "lone surrogates in names": (DESIGNS, lambda: around(cam(**{"@": 1}), "\\udc00")),
    "invalid UTF-8": (DESIGNS, lambda: b'{"name":"' + b"\xff" * (LARGEST - 11) + b'"}'),
    "UTF-16": (DESIGNS, lambda: around(cam(name="@"), "a").encode()[: LARGEST // 2].decode()
               .encode("utf-16-le")),
    "gzip": (DESIGNS, lambda: gzip.compress(b"[" * 200_000_000, 1)),
    "NaN": (DESIGNS, lambda: full('{"a":[', "NaN", "]}")),
    "Infinity by name": (DESIGNS, lambda: json.dumps(dict.fromkeys(names(42_000), float("inf")))),
    # Numbers.
    "a number of a million digits": (DESIGNS, lambda: '{"speed_rpm":' + "9" * 10**6 + "}"),
    "a fraction of a million digits": (DESIGNS, lambda: '{"speed_rpm":0.' + "9" * 10**6 + "}"),
    "a huge exponent": (DESIGNS, lambda: json.dumps(cam()).replace("210", "1e999999999", 1)),
    "an exponent of a million digits": (DESIGNS, lambda: '{"speed_rpm":1e' + "9" * 10**6 + "}"),
    "numbers of 4000 digits": (DESIGNS, lambda: full('{"a":[', "9" * 4000, "]}")),
    "a negative exponent": (DESIGNS, lambda: json.dumps(cam()).replace("210", "1e-99999999", 1)),
    "digits in a text": (DESIGNS, lambda: around(cam(speed_rpm="@"), "9")),
    # Names.
    "many names": (DESIGNS, lambda: json.dumps(cam(**names(60_000)))),
    "short names": (DESIGNS, lambda: "{" + ",".join(f'"{i:x}":0' for i in range(105_000)) + "}"),
    "the same name": (DESIGNS, lambda: full("{", '"a":0', "}")),
    "a known name again": (DESIGNS, lambda: full("{", '"name":"a"', "}")),
    "a long name": (DESIGNS, lambda: around(cam(**{"@": 1}), "name")),
    "known names at wrong places": (
        DESIGNS, lambda: full('{"program":[', '{"kind":"dwell","name":1,"limits":1,"load":2}', "]}")
    ),
    # Lists of what is wrong.
    "segments without anything": (DESIGNS, lambda: full('{"program":[', "{}", "]}")),
    "10 000 dwells": (
        DESIGNS, dumped(lambda: cam(program=[{"kind": "dwell", "angle_deg": 1}] * 10_000))
    ),
    "segments of an unknown kind": (
        DESIGNS, dumped(lambda: cam(program=[{"kind": "rize", "beta": 1}] * 35_000))
    ),
    "limits of an unknown kind": (DESIGNS, dumped(lambda: cam(limits=[{"kind": "x"}] * 60_000))),
    "1000 wrong values": (
        DESIGNS, dumped(lambda: cam(program=[{"kind": "rise", "angle_deg": "1", "hub": "3 mm",
                                              "winkel": "2", "law": "sin"}] * 100))
    ),
    "long wrong values": (
        DESIGNS, dumped(lambda: cam(program=[{"kind": "x" * 5000, "a" * 4000: "1"}] * 100))
    ),
    "long lists as values": (
        DESIGNS, dumped(lambda: cam(program=[{"kind": "rise", "angle_deg": [0] * 3000}] * 100))
    ),
    "a list for a number": (DESIGNS, dumped(lambda: cam(speed_rpm=[0] * 300_000))),
    "objectives in lists": (DESIGNS, lambda: full('{"objective":[', '{"kind":"rms_jerk"}', "]}")),
    "points of letters": (
        DESIGNS, dumped(lambda: cam(program=[{**table(9), "points": [["a", "b"]] * 80_000}]))
    ),
    "columns of texts": (DESIGNS, dumped(lambda: cam(
        program=[{"kind": "table", "angle_deg": 3, "angles_deg": ["1"] * 2000}] * 90))),
    # What is valid, or nearly.
    "a long table": (DESIGNS, dumped(lambda: cam(program=[table(20_000)]))),
    "100 tables": (DESIGNS, dumped(lambda: cam(program=[table(600, 3.6)] * 100))),
    "100 tables without a sum": (DESIGNS, dumped(lambda: cam(program=[table(600, 3.0)] * 100))),
    "free angles and lifts": (
        DESIGNS, dumped(lambda: cam(program=moves(
            100, angle_deg={"min": 1, "max": 9}, lift_mm={"min": 1, "max": 9})))
    ),
    "windows over each other": (
        DESIGNS, dumped(lambda: cam(program=moves(100, windows=windows())))
    ),
    "a free arm": (
        DESIGNS, dumped(lambda: cam(
            program=[{**each, "lift_deg": 5} for each in moves(100, lift_mm=None)],
            follower={"kind": "oscillating_roller", "roller_radius_mm": 10,
                      "arm_mm": {"min": 1, "max": 1000}}))
    ),
    "a free arm with windows": (
        DESIGNS, dumped(lambda: cam(
            program=[{"kind": kind, "angle_deg": 3.6, "lift_deg": 5, "windows": [
                {"from_deg": 0.01 * i, "to_deg": 3.0, "travel_deg": {"min": -1 - i, "max": 50 + i}}
                for i in range(50)]} for kind in ["rise", "return"] * 50],
            follower={"kind": "oscillating_roller", "roller_radius_mm": 10,
                      "arm_mm": {"min": 1, "max": 1000}}))
    ),
    "a sweep over windows": (SWEEPS, dumped(lambda: swept(base=cam(
        program=moves(100, windows=windows()), limits=[
            {"kind": "acceleration", "max_mm_per_s2": 100}]), axes=[
            {"kind": "range", "pointer": "/program/0/angle_deg", "start": 3, "stop": 3.1,
             "count": 9}]))),
    "50 cams of 100 segments": (
        SETS, dumped(lambda: {"cams": [{"spec": cam(program=moves(100))}] * 50})
    ),
    "50 cams of 100 free segments": (
        SETS, dumped(lambda: {"cams": [{"spec": cam(program=moves(
            100, angle_deg={"min": 1, "max": 9}, lift_mm={"min": 1, "max": 9}))}] * 50})
    ),
    "5000 cams": (SETS, lambda: full('{"cams":[', '{"spec":{}}', "]}")),
    "cams with wrong segments": (
        SETS, dumped(lambda: {"cams": [{"spec": cam(program=[{"kind": "rise"}] * 90)}] * 50})
    ),
    "linked fields": (SWEEPS, dumped(linked)),
    "separate fields": (SWEEPS, dumped(separate)),
    "values that are lists": (SWEEPS, dumped(lambda: on_lists([[1]] * 10))),
    "values that are numbers": (SWEEPS, dumped(lambda: on_lists(31.5))),
    "values that are deep": (SWEEPS, lambda: json.dumps(swept()).replace(
        "[30, 31]", "[" + "[" * 200_000 + "]" * 200_000 + "]")),
    "a hypercube": (SWEEPS, dumped(lambda: swept(
        axes=[{"kind": "range", "pointer": f"/program/{i}/angle_deg", "start": 1, "stop": 2}
              for i in range(20)], base=cam(program=moves(100)),
        plan={"kind": "latin_hypercube", "count": 20_000}))),
    "pointers into a table": (SWEEPS, dumped(lambda: swept(
        base=cam(program=[table(20_000)]),
        axes=[{"kind": "list", "pointer": "/program/0/points/0/0/0", "values": [1],
               "linked_pointers": [f"/program/0/points/{i}/0" for i in range(90)]}] * 20))),
    "a sweep over a long table": (SWEEPS, dumped(lambda: swept(
        base=cam(program=[table(20_000)]),
        axes=[{"kind": "list", "pointer": f"/program/0/points/{i}/0", "values": [1, 2]}
              for i in range(14)]))),
    "a measured cam": (MEASURED, dumped(lambda: {
        "points_mm": [[i / 3, -i / 7] for i in range(20_000)], "follower": ROLLER})),
    "too many points": (MEASURED, lambda: full(
        '{"follower":{"kind":"translating_roller","roller_radius_mm":1},"points_mm":[',
        "[1,2]", "]}")),
    "points of texts": (MEASURED, lambda: full('{"points_mm":[', '["1","2"]', "]}")),
    "a train with a long table": (TRAINS, dumped(lambda: {
        "cam": cam(program=[table(20_000)]), "masses": [{}] * 30_000})),
}  # fmt: skip
