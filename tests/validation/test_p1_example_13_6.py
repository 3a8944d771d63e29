"""Example 13-6: the offset translating roller cam, its true values, and why its table differs.

Source: a published worked example (13-6) with a printed program and a printed table of 19 rows.
Lift 30 mm, prime radius 60 mm (the example says base radius), roller radius 10 mm, offset 20 mm,
counter-clockwise at 10 rad/s; rise 60° cycloidal, dwell 30°, return 60° cycloidal, dwell 210°.

**The true values.** `textbook` computes the seven columns, pressure angle and curvature to forty
digits from the textbook formulas, typed here a second time; the product must agree to 1e-9.

**The printed table.** Its rows are not at the printed angles. The program stepped the cam angle by
1/300° (by 1/100° in the outer dwell) and stored each result under the angle rounded to a whole
number, so that row k was written over until the last angle that rounds to k. Rounding was
banker's: a half goes to the even neighbour, and every printed row is even, so row k keeps k + 0.5.
Except where the sum of the steps came out just above the half: after 150 steps it is
0.5000000000000013, which rounds to 1, and row 0 keeps the angle 0.49667°; so do rows 20
(20.49667°) and 80 (80.49°), and row 360 keeps the last angle, 360°. The profile was computed after
that, from the arrays: in rows 0 to 40 and 160 to 360 the normal's direction was formed at exactly
k, with the velocity there but the displacement of the array; in rows 60 to 140 at the row's own
angle.

`emulated` does just that with the product's motion and profile, and every printed cell comes out,
to the printed digit. Nothing is adjusted: the angles follow from adding up the steps in double
precision.
"""

import runpy
from decimal import Decimal
from math import pi
from pathlib import Path

import numpy as np
import pytest

from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import cam_profile
from synthesis.spec.design_spec import DesignSpec
from tests.validation.textbook import OffsetRoller

DOCS = Path(__file__).resolve().parents[2] / "docs" / "reference"

OMEGA = 10.0
COLUMNS = ("s", "v", "a", "pitch x", "pitch y", "profile x", "profile y")

# cam angle: s mm, v mm/s, a mm/s², pitch x y mm, profile x y mm; as printed
PRINTED = """
    0:  0.00    0.39    893.60  20.49  56.39  17.16  46.97
   20:  6.24  442.42  14418.95  40.73  51.83  40.74  41.83
   40: 24.50  416.54 -15315.27  67.86  48.66  63.76  39.54
   60: 30.00    0.00      0.00  85.19  25.22  75.61  22.38
   80: 30.00    0.00      0.00  88.68  -5.42  78.70  -4.81
  100: 29.00 -156.42 -15315.27  80.50 -35.26  72.12 -29.80
  120: 14.50 -572.57    899.59  51.08 -53.30  48.99 -43.53
  140:  0.75 -130.45  14415.69  21.02 -56.95  19.37 -47.08
  160:  0.00    0.00      0.00   0.03 -60.00  -0.06 -50.00
  180:  0.00    0.00      0.00 -20.49 -56.39 -17.16 -46.96
  200:  0.00    0.00      0.00 -38.54 -45.98 -32.19 -38.26
  220:  0.00    0.00      0.00 -51.95 -30.03 -43.33 -24.95
  240:  0.00    0.00      0.00 -59.08 -10.45 -49.25  -8.62
  260:  0.00    0.00      0.00 -59.09  10.39 -49.23   8.74
  280:  0.00    0.00      0.00 -51.98  29.97 -43.27  25.05
  300:  0.00    0.00      0.00 -38.59  45.94 -32.09  38.34
  320:  0.00    0.00      0.00 -20.55  56.37 -17.04  47.01
  340:  0.00    0.00      0.00  -0.03  60.00   0.06  50.00
  360:  0.00    0.00      0.00  20.00  56.57  16.67  47.14
"""
TABLE = {
    int(row): cells.split()
    for row, cells in (line.split(":") for line in PRINTED.split("\n")[1:-1])
}


def spec() -> DesignSpec:
    move = {"angle_deg": 60.0, "lift_mm": 30.0, "law": {"kind": "cycloidal"}}
    return DesignSpec.model_validate(
        {
            "name": "Example 13-6",
            "speed_rpm": OMEGA * 60.0 / (2.0 * pi),
            "rotation": "ccw",
            "program": [
                {"kind": "rise", **move},
                {"kind": "dwell", "angle_deg": 30.0},
                {"kind": "return", **move},
                {"kind": "dwell", "angle_deg": 210.0},
            ],
            "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0, "offset_mm": 20.0},
            "base_radius_mm": 50.0,
        }
    )


SPEC = spec()
MOTION = Motion.of(SPEC.placed_segments())
SIZE = (20.0, float(np.sqrt(60.0**2 - 20.0**2)))


def product(degrees: np.ndarray):
    return cam_profile(MOTION, SPEC.follower, SIZE, SPEC.rotation, np.radians(degrees))


# --- the true values ---------------------------------------------------------------------------


EXAMPLE = OffsetRoller(h=30, rise=60, dwell=30, prime=60, e=20, Rr=10, omega=10)


def reported(degrees: np.ndarray) -> dict[str, np.ndarray]:
    p = product(degrees)
    return {
        "s": p.s[0],
        "v": p.s[1] * OMEGA,
        "a": p.s[2] * OMEGA**2,
        "pitch x": p.pitch_x,
        "pitch y": p.pitch_y,
        "profile x": p.x,
        "profile y": p.y,
        "tan of pressure angle": np.tan(p.pressure_angle),
        "curvature": p.curvature,
    }


# every half degree, and as many angles that are nothing special
ANGLES = np.sort(np.concatenate([np.arange(720) / 2.0, np.arange(180) * 1.987654321 + 0.123456]))


@pytest.fixture(scope="module")
def truth() -> dict[str, np.ndarray]:
    rows = [EXAMPLE.at(Decimal(float(angle))) for angle in ANGLES]
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@pytest.mark.parametrize("column", [*COLUMNS, "tan of pressure angle", "curvature"])
def test_the_true_values_at_the_true_angles(column: str, truth: dict[str, np.ndarray]):
    found = reported(ANGLES)[column]
    worst = int(np.argmax(abs(found - truth[column])))
    assert abs(found - truth[column])[worst] <= 1e-9, (
        f"{column} at {ANGLES[worst]}°: {found[worst]}, truly {truth[column][worst]}"
    )
    scale = max(np.max(abs(truth[column])), 1.0)
    np.testing.assert_allclose(found / scale, truth[column] / scale, rtol=0, atol=1e-12)


def test_the_dimensions_are_those_of_the_example():
    answer = SPEC.follower.dimensions(SIZE)
    assert answer["base_radius_mm"] == pytest.approx(50.0, abs=1e-12)
    assert answer["prime_radius_mm"] == pytest.approx(60.0, abs=1e-12)
    assert SPEC.machine().omega == pytest.approx(OMEGA, rel=1e-15)


# --- the printed table -------------------------------------------------------------------------


def stored_angles() -> dict[int, float]:
    """What each row of the program's arrays holds in the end: the last angle that rounds to it."""
    row = {}
    for start, end, step in (
        (0.0, 60.0, 1 / 300),
        (60.0, 90.0, 1 / 100),
        (90.0, 150.0, 1 / 300),
        (150.0, 360.0, 1 / 300),
    ):
        angle = start
        while angle <= end:
            row[round(angle)] = angle  # Python rounds halves to even, as that program did
            angle += step
    return row


def emulated(k: int, angle: float) -> list[float]:
    """Row k of the table, from the product's values at the angle that the row holds."""
    p = product(np.array([angle]))
    s, v, a = p.s[0, 0], p.s[1, 0] * OMEGA, p.s[2, 0] * OMEGA**2
    normal = np.array([p.normal_x[0], p.normal_y[0]])
    if k <= 40 or k >= 160:
        normal = normal_at_row(k, s)
    x, y = np.array([p.pitch_x[0], p.pitch_y[0]]) - SPEC.follower.roller_radius_mm * normal
    return [s, v, a, p.pitch_x[0], p.pitch_y[0], x, y]


def normal_at_row(k: int, stored_s: float) -> np.ndarray:
    """The product's normal at exactly k degrees, if the follower stood there at ``stored_s``."""
    s = MOTION.derivatives(np.radians([k]))[:, 0]
    e, s0 = SIZE
    held = Motion((), MOTION.curve.rescale(0.0, 1.0, stored_s - s[0], 1.0))
    p = cam_profile(held, SPEC.follower, (e, s0), SPEC.rotation, np.radians([float(k)]))
    return np.array([p.normal_x[0], p.normal_y[0]])


def as_printed(value: float) -> str:
    return f"{round(value, 2) + 0.0:.2f}"


def test_the_rows_hold_other_angles_than_they_are_printed_at():
    held = stored_angles()
    special = {0: 0.5 - 1 / 300, 20: 20.5 - 1 / 300, 80: 80.49, 360: 360.0}
    for k in TABLE:
        assert held[k] == pytest.approx(special.get(k, k + 0.5), abs=1e-9)


def test_the_printed_table_is_explained_cell_by_cell():
    held = stored_angles()
    wrong = [
        f"row {k}, {column}: printed {cell}, emulated {as_printed(value)} ({value})"
        for k, cells in TABLE.items()
        for column, cell, value in zip(COLUMNS, cells, emulated(k, held[k]), strict=True)
        if as_printed(value) != cell
    ]
    assert sum(len(cells) for cells in TABLE.values()) == 133
    assert not wrong, "\n".join(wrong)


def test_at_the_printed_angles_the_table_is_wrong():
    # so that the explanation is not mistaken for agreement
    true = reported(np.array(list(TABLE), dtype=float))
    differ = [
        (k, column)
        for i, (k, cells) in enumerate(TABLE.items())
        for column, cell in zip(COLUMNS, cells, strict=True)
        if as_printed(true[column][i]) != cell
    ]
    assert len(differ) == 83
    assert all(k != 360 for k, _ in differ)


# --- the page that tells it --------------------------------------------------------------------


def test_the_page_shows_what_its_command_prints(capsys: pytest.CaptureFixture[str]):
    runpy.run_path(str(DOCS / "p1.py"), run_name="__main__")
    printed = capsys.readouterr().out.strip()
    page = (DOCS / "p1.md").read_text(encoding="utf-8")
    assert printed in page, "docs/reference/p1.md is out of date: python docs/reference/p1.py"
