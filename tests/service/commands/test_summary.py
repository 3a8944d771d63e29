"""The summary as the terminal prints it: numbers in their units, beside those of the usual law."""

import synthesis as c
from service.commands.display import Table
from service.commands.tables import describe_design
from synthesis.design.design import Design


def design(kind: str = "cycloidal") -> Design:
    law = {"kind": kind}
    program = [
        {"kind": "rise", "angle_deg": 120, "lift_mm": 20, "law": law},
        {"kind": "dwell", "angle_deg": 60},
        {"kind": "return", "angle_deg": 100, "lift_mm": 20, "law": law},
        {"kind": "dwell", "angle_deg": 80},
    ]
    follower = {"kind": "translating_roller", "roller_radius_mm": 12.0, "offset_mm": 0.0}
    spec = {"speed_rpm": 60, "program": program, "follower": follower, "base_radius_mm": 50.0}
    return c.synthesise(c.DesignSpec.model_validate(spec))


def test_the_tables_of_the_summary_follow_the_lines() -> None:
    printed = list(describe_design(design(), 0.01))
    tables = {each.title: each for each in printed if isinstance(each, Table)}
    assert list(tables) == ["Motion", "Coefficients", "Geometry"]
    rows = list(zip(*(column.cells for column in tables["Motion"].drawn().columns), strict=True))
    # Cv h ω/β = 2 · 20 mm / (120°/360 s)
    assert rows[3] == (
        "velocity, rise 0–120°", "mm/s", "120", "60.000", "0", "0.000", "73.4847", "0",
    )  # fmt: skip
    names = [row[0] for row in tables["Coefficients"].rows]
    assert names[:2] == ["rise 0–120°", "  reference: modified sine, R-R"]
    drawn = tables["Geometry"].drawn().columns
    figures = list(zip(*(column.cells for column in drawn), strict=True))
    assert ("outer radius", "70", "mm", "120.000") in figures
    assert ("least hollow radius", "no hollow", "", "–") in figures


def test_peaks_of_an_infinite_derivative_are_told_to_be_those_between_jumps() -> None:
    printed = describe_design(design("parabolic"), 0.01)
    motion = next(each for each in printed if isinstance(each, Table) and each.title == "Motion")
    rms = motion.columns.index("rms")
    jumping = [row[0] for row in motion.rows if row[rms] == "infinite"]
    assert jumping == ["jerk, turn between jumps", "jerk, rise 0–120° between jumps",
                       "jerk, return 180–280° between jumps"]  # fmt: skip
    assert not any("jumps" in str(row[0]) for row in motion.rows if row[rms] != "infinite")
