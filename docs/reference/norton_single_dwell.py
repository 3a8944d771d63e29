"""Print the table of norton-single-dwell.md: textbook laws, and the least peak acceleration.

python docs/reference/norton_single_dwell.py
"""

from collections.abc import Iterator
from math import pi
from typing import Any

from scipy.optimize import brentq

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design

INCH = 25.4  # mm
OMEGA = 15.0  # rad/s
BETA = pi / 2.0
TOLERANCE = 2e-3
TEXTBOOK = ("double_harmonic", "polynomial_3_4_5_6", "kloomok_muffley_8")


def unit(order: int) -> float:
    """What 1 is worth for unit lift and angle: h ωᵏ/βᵏ [in/sᵏ]."""
    return (OMEGA / BETA) ** order


def spec(law: str, objective: str = "peak_acceleration", jerk: float | None = None) -> DesignSpec:
    """The cam with a given law, or a free one.

    Args:
        law: kind of the law of rise and return.
        objective: what is reported, or made small.
        jerk: largest jerk [in/s³].
    """
    move: dict[str, Any] = {"angle_deg": 90.0, "lift_mm": INCH, "law": {"kind": law}}
    return DesignSpec.model_validate(
        {
            "name": "single-dwell cam",
            "speed_rpm": OMEGA * 30.0 / pi,
            "program": [
                {"kind": "rise", **move},
                {"kind": "return", **move},
                {"kind": "dwell", "angle_deg": 180.0},
            ],
            "follower": {"kind": "translating_roller", "roller_radius_mm": 8.0, "offset_mm": 0.0},
            "base_radius_mm": 90.0,
            "limits": [] if jerk is None else [{"kind": "jerk", "max_mm_per_s3": jerk * INCH}],
            "objective": {"kind": objective},
            "tolerance": TOLERANCE,
        }
    )


def peaks(law: str) -> tuple[float, float]:
    """Peak acceleration [in/s²] and jerk [in/s³] of the finished cam with a given law."""
    a = synthesise(spec(law)).objectives["peak_acceleration_mm_per_s2"]
    j = synthesise(spec(law, "peak_jerk")).objectives["peak_jerk_mm_per_s3"]
    return a / INCH, j / INCH


def least(jerk: float) -> float:
    """Exact least peak acceleration from a dwell to a turn under a jerk cap, unit lift and angle.

    Jerk +J up to A, none, −J down to −A, none until the turn. That the turn is a stop sets the
    two halts, that the lift is 1 gives A (1/4 − k/4 − 11k²/48) = 1 with k = A/J.
    """

    def short(a: float) -> float:
        k = a / jerk
        return a * (0.25 - k / 4.0 - 11.0 * k * k / 48.0) - 1.0

    return float(brentq(short, 4.0, 0.25 * jerk, xtol=1e-14))


def optimum(jerk: float) -> Design:
    """The free law with the least peak acceleration whose jerk is at most that [in/s³]."""
    return synthesise(spec("spline", jerk=jerk))


def rows() -> Iterator[str]:
    for law in TEXTBOOK:
        a, j = peaks(law)
        best = optimum(j)
        proof = best.certificate
        assert proof.value is not None
        assert proof.lower_bound is not None
        exact = least(j / unit(3)) * unit(2)
        yield (
            f"| `{law}` | {a:.2f} | {j:.0f} | {proof.value / INCH:.2f} "
            f"| {proof.lower_bound / INCH:.2f} | {exact:.2f} | {100.0 * (1.0 - exact / a):.1f} % |"
        )


def main() -> None:
    print(
        "| textbook law | its peak acceleration in/s² | its peak jerk in/s³ "
        "| designed, same jerk in/s² | proven bound in/s² | exact optimum in/s² | lower by |"
    )
    print("|---|" + "--:|" * 6)
    for row in rows():
        print(row, flush=True)


if __name__ == "__main__":
    main()
