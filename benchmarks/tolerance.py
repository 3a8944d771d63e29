"""What a tolerance costs: proven gap and true error of whole designs against their time."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.axis import Axis, relative, seconds
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from benchmarks.truth import SCENES, Scene
from synthesis import synthesise
from synthesis.design.design import Design

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
LEAST = 1e-7  # errors below that are drawn at the edge
TEXT = """Whole designs at tolerances from 10 % to 10⁻⁵, certificate included. *Gap* is what the
design itself proves: how far at most its value lies above the best of all motion laws. *Error* is
how far it does lie above the optimum: that is a closed form for the last three, and for the base
radius a reference with 2 × 2000 intervals of constant jerk, known to 6·10⁻⁶. An honest gap is never
smaller than the error. Where a tolerance is not reached the status is `feasible`."""


@dataclass(frozen=True)
class Outcome:
    """One design at one tolerance."""

    scene: Scene
    tolerance: float
    time: Timing
    design: Design

    @property
    def gap(self) -> float:
        """Proven."""
        gap = self.design.certificate.gap
        assert gap is not None
        return gap

    @property
    def error(self) -> float:
        """Against the optimum; over the value, as the gap is."""
        value = self.design.certificate.value
        assert value is not None
        return 1.0 - self.scene.exact / value


def run(effort: Effort = FULL) -> Section:
    """Every scene at every tolerance."""
    cases = [(scene, tolerance) for scene in SCENES for tolerance in TOLERANCES]
    found = _outcomes(effort.some(cases), effort)
    return Section(
        "Tolerance",
        TEXT,
        [
            _diagram(found, "gap", "Tolerance: proven gap against time"),
            _diagram(found, "error", "Tolerance: true error against time"),
            Table(
                ("scene", ">tolerance", ">time", ">proven gap", ">true error", "status"),
                [_row(outcome) for outcome in found],
            ),
        ],
    )


def _outcomes(cases: list[tuple[Scene, float]], effort: Effort) -> list[Outcome]:
    specs = {
        f"{scene.name} {tolerance}": scene.spec(tolerance=tolerance) for scene, tolerance in cases
    }
    designs = {name: synthesise(spec) for name, spec in specs.items()}
    calls: dict[str, Call] = {
        name: (lambda spec=spec: synthesise(spec)) for name, spec in specs.items()
    }
    times = in_turns(calls, effort.repeats(5), 0)
    return [
        Outcome(*case, times[name], designs[name]) for case, name in zip(cases, specs, strict=True)
    ]


def _row(found: Outcome) -> tuple[str, ...]:
    scene, error = found.scene, f"{found.error:.1e}"
    return (
        scene.name,
        relative(found.tolerance),
        str(found.time),
        f"{found.gap:.1e}",
        f"below {scene.known_to:.0e}" if abs(found.error) < scene.known_to else error,
        found.design.status,
    )


def _diagram(found: list[Outcome], kind: str, title: str) -> Diagram:
    series = []
    for scene in dict.fromkeys(outcome.scene for outcome in found):
        points = [
            Point(
                one.time.median,
                max(getattr(one, kind), scene.known_to),
                one.time.low,
                one.time.high,
            )
            for one in found
            if one.scene == scene
        ]
        series.append(Series(scene.name, points))
    reported = "One curve a scene; each mark is a tolerance, from 10 % to 10⁻⁵."
    axis = Axis("proven gap" if kind == "gap" else "true error", relative, least=LEAST)
    return Diagram(f"tolerance-{kind}", title, reported, Axis("time", seconds), axis, series)
