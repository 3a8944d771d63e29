"""A cam whose closing spring is left free: motion and size first, then the spring, then both.

The spring has no say in the cam unless a limit on forces gives it one. So the cam is designed
without these limits, the best spring of its motion is a linear program, and the cam is designed
again with that spring and all limits; where they change it, spring and cam once more.

The best spring has the least peak of the contact force at which the follower does not float. At
every cam angle and every speed requested the contact force is linear in rate k and preload F0,

    N = (σ s k + F0 + σ (m s'' ω² + c s' ω + P + W)) / (λ cos α − friction),

and of the speed no more than three values can be extreme. So it is a linear program in k, F0 and
the peak, solved by exchange: rows at some cam angles, then at the worst between them, until none is
violated.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.forces.reduced import MILLI, ReducedLoad
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.limits.forces import ContactForce
from synthesis.catalogue.motion import Motion
from synthesis.design.assumptions import assumptions
from synthesis.design.design import WITHOUT_CAM, Certificate, Design, Effort, Proof, all_close
from synthesis.design.identity import design_id
from synthesis.errors import SolverFailed
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.state import Stage
from synthesis.spec.design_spec import DesignSpec

CAM_ITERATIONS: Final = 3  # of cam and spring
SAME: Final = 1e-3  # of the peak force: springs nearer than this are as good as one
FIRST, DENSE = 9, 33  # points on a piece: of the first rows, of the search for what they miss
MAX_ITERATIONS, ZOOMS = 12, 10  # of adding rows; of narrowing the place of a peak
FAN: Final = np.linspace(-1.0, 1.0, 9)
MISSED = 1e-10  # of the peak: what rows between their points may miss
SPARE = 1e-4  # of the largest force without a spring: kept off float, for the certificate's sake
FLOATING = 1e4  # price of a newton of float, in newtons of peak: no spring helps where it is paid

Solver = Callable[[DesignSpec], Design]
Numbers = dict[str, float]
Indices = NDArray[np.intp]


def design_with_spring(spec: DesignSpec, solve: Solver) -> Design:
    """The cam and its spring, which is free; ``solve`` designs a cam with everything given."""
    load = spec.load
    assert load is not None

    def given(numbers: Numbers) -> DesignSpec:
        return spec.model_copy(update={"load": load.with_spring(numbers)})

    # 1. The cam without limits on forces: the spring, at its least, has no say in it.
    kept = [limit for limit in spec.limits if not limit.needs_load]
    numbers = {name: low for name, (low, _) in load.free_spring.items()}
    first = solve(given(numbers).model_copy(update={"limits": kept}))
    design, peak, stages = first, float("inf"), list[Effort]()
    for _ in range(CAM_ITERATIONS if first.motion else 0):
        # 2. The best spring for its motion; the end where that is no better than the last one.
        spring, chosen = _best_spring(spec, design)
        if design is not first and spring.peak >= peak * (1.0 - SAME):
            break
        # 3. The cam with this spring and all limits.
        candidate = solve(given(chosen))
        if design is not first and candidate.status in WITHOUT_CAM:
            break
        design, numbers, peak = candidate, chosen, spring.peak
        stages.append(Effort(**asdict(spring.stage)))
        if len(kept) == len(spec.limits) or not design.certificate.certified:
            break
    return _answer(spec, numbers, design, first, stages)


def _best_spring(spec: DesignSpec, design: Design) -> tuple[ChosenSpring, Numbers]:
    """The best spring for the motion of a cam, and its numbers that were free, as on the wire."""
    complete = design.completed_spec.model_copy(update={"load": spec.load})
    machine, load = complete.machine(), complete.load
    assert load is not None
    assert load.spring is not None
    assert machine.load is not None
    # Rate and preload along the displacement of one unit of each on the wire [N/mm, N].
    names = load.spring.requested
    reduced = load.with_spring(dict.fromkeys(names, 1.0)).reduced(complete.follower, 1.0)
    units = (reduced.rate, reduced.preload)
    rates, preloads = (
        (low * unit, high * unit)
        for (low, high), unit in zip(load.spring.ranges, units, strict=True)
    )
    forces = (limit for limit in spec.limits if isinstance(limit, ContactForce))
    floor = max((limit.min_n or 0.0 for limit in forces), default=0.0)
    size = tuple(design.size)
    program = SpringProgram(design.curve, machine, machine.load, size, rates, preloads, floor)
    spring = program.chosen()
    values = dict(zip(names, (spring.rate / units[0], spring.preload / units[1]), strict=True))
    free = load.free_spring.items()
    return spring, {name: min(max(values[name], low), high) for name, (low, high) in free}


def _answer(
    spec: DesignSpec, numbers: Numbers, design: Design, first: Design, stages: list[Effort]
) -> Design:
    """The cam as the answer to the spec, with bounds that hold for every spring."""
    fields = {f"load/spring/{name}": value for name, value in numbers.items()}
    proofs = [design.certificate, *design.certificate.other_objectives]
    bounds = [first.certificate, *first.certificate.other_objectives]
    # in the order of the objectives; of no cam there is a single proof, which has no value
    for_all = [_for_all(one, other) for one, other in zip(proofs, bounds, strict=False)]
    certificate = Certificate(
        certified=design.certificate.certified,
        other_objectives=for_all[1:],
        **for_all[0].model_dump(),
    )
    close = all_close(for_all, spec)
    status = "feasible" if design.status == "optimal" and not close else design.status
    report = design.report.model_copy(
        update={
            "stages": [*(first.report.stages if stages else ()), *stages, *design.report.stages],
            "seconds": design.report.seconds + (first.report.seconds if stages else 0.0),
        }
    )
    return design.model_copy(
        update={
            "id": design_id(spec), "spec": spec,
            "assumptions": assumptions(spec),
            "free_parameters": {**design.free_parameters, **fields},
            "certificate": certificate, "status": status, "report": report,
        }
    )  # fmt: skip


def _for_all(proof: Proof, without: Proof) -> Proof:
    """A proof with the bound that was found without limits on forces: it holds for any spring."""
    value, lower = proof.value, without.lower_bound
    own = Proof.model_validate(proof.model_dump(include=set(Proof.model_fields)))
    if value is None or lower is None or proof.lower_bound == lower:
        return own
    gap = max(value - lower, 0.0) / max(abs(value), 1e-300)
    over = f"{without.bound_valid_for}, any spring, without limits on forces"
    return own.model_copy(
        update={"lower_bound": min(lower, value), "gap": gap, "bound_valid_for": over}
    )


@dataclass(frozen=True)
class ChosenSpring:
    """A spring for a given motion.

    Attributes:
        rate, preload: along the displacement [N/mm, N].
        peak: largest contact force at any speed asked for [N]. lacking: what it floats by [N].
    """

    rate: float
    preload: float
    peak: float
    lacking: float
    stage: Stage


class _Rows(NamedTuple):
    """N at n places: (s k + F0 + low)/grip at least, (s k + F0 + high)/grip at most; (n,) each."""

    s: Array
    low: Array
    high: Array
    grip: Array


@dataclass(frozen=True, eq=False)
class SpringProgram:
    """A finished cam whose spring is sought.

    Attributes:
        rates, preloads: ends of what may be chosen, along the displacement.
        floor: contact force that must be left at least [N].
    """

    motion: Motion
    machine: Machine
    load: ReducedLoad
    size: tuple[float, ...]
    rates: tuple[float, float]
    preloads: tuple[float, float]
    floor: float = 0.0

    def chosen(self) -> ChosenSpring:
        """The best spring.

        Raises:
            SolverFailed: HiGHS gave no answer.
        """
        started = time.perf_counter()
        curve, _ = self.motion.curve.split_at(self.load.process.breaks[1:-1])
        piece, x = _spread(curve, FIRST)
        rows, steps, spring = self._at(curve, piece, x), 0, (0.0, 0.0, 0.0, 0.0)
        for _ in range(MAX_ITERATIONS):
            steps += 1
            spring = self._solved(rows)
            violated = self._violated(curve, *spring)
            if not violated:
                break
            rows = _Rows(*map(np.concatenate, zip(rows, *violated, strict=True)))
        seconds = time.perf_counter() - started
        stage = Stage(
            "spring", "LP", "HiGHS", 4, 2 * len(rows.s), steps, seconds, "solved",
            f"least peak of the contact force for this motion: {spring[2]:.6g} N",
        )  # fmt: skip
        return ChosenSpring(*spring, stage)

    def _solved(self, rows: _Rows) -> tuple[float, float, float, float]:
        """Rate, preload, peak and float of the rows at hand."""
        force = float(np.max(np.abs(rows.high) + np.abs(rows.low), initial=1e-300))
        long = float(np.max(np.abs(rows.s), initial=1e-300))
        unit = np.array([force / long, force, force, force])
        grip, one = rows.grip, np.ones(len(rows.s))
        floor = self.floor + SPARE * force
        off = np.stack([-rows.s, -one, 0.0 * one, -grip], axis=1)
        below = np.stack([rows.s, one, -grip, 0.0 * one], axis=1)
        matrix = np.concatenate([off, below]) * unit / force
        rhs = np.concatenate([rows.low - floor * grip, -rows.high]) / force
        ends = (self.rates, self.preloads, (-np.inf, np.inf), (0.0, np.inf))
        low, high = (np.array([end[k] for end in ends]) / unit for k in (0, 1))
        program = LinearRows(sparse.csc_matrix(matrix), rhs, 0, low, high)
        # of springs of one peak the softest
        price = np.array([1e-9, 1e-9, 1.0, FLOATING])
        (result,) = minimise_each(program, [price])
        if result.stopped is not StopReason.SOLVED:
            raise SolverFailed("HiGHS", result.stopped.value, "The spring's program has no answer.")
        rate, preload, peak, lacking = (result.x * unit).tolist()
        return rate, preload, peak, lacking if lacking > SPARE * force else 0.0

    def _violated(
        self, curve: Piecewise, rate: float, preload: float, peak: float, lacking: float
    ) -> list[_Rows]:
        """Rows at the worst places of every piece where the spring violates them."""
        result, pieces, allowed = list[_Rows](), np.arange(curve.count), MISSED * abs(peak)
        for largest in (True, False):
            piece, x = _spread(curve, DENSE)
            reach = np.diff(curve.breaks) / (DENSE - 1)
            for _ in range(ZOOMS):
                rows = self._at(curve, piece, x)
                spring = rows.s * rate + preload
                if largest:
                    excess = (spring + rows.high) / rows.grip - peak
                else:
                    excess = self.floor - lacking - (spring + rows.low) / rows.grip
                table = excess.reshape(curve.count, -1)
                best = np.argmax(table, axis=1)
                worst, centre = table[pieces, best], x.reshape(table.shape)[pieces, best]
                reach = reach / 3.0
                spread = centre[:, None] + reach[:, None] * FAN
                x = np.clip(spread, curve.breaks[:-1, None], curve.breaks[1:, None]).ravel()
                piece = np.repeat(pieces, len(FAN))
            beyond = np.flatnonzero(worst > allowed)
            if len(beyond):
                result.append(self._at(curve, beyond, centre[beyond]))
        return result

    def _at(self, curve: Piecewise, piece: Indices, x: Array) -> _Rows:
        """What the force is made of at cam angles of pieces."""
        load, flank = self.load, self.machine.follower.flanks[0]
        s = curve.jet(x, piece, 3)
        middle = 0.5 * (curve.breaks[:-1] + curve.breaks[1:])
        process = load.process.at(x, load.process.piece_of(middle)[piece], 0)
        sine, cosine = pressure_angle_sine_cosine(flank.trace, s, self.size)
        placed = [segment for segment in self.motion.segments if segment.angle > 0.0]
        starts = [segment.start for segment in placed]
        which = np.searchsorted(starts, middle[piece], side="right") - 1
        sense = np.array([load.sliding_sense(segment) for segment in placed])[which]
        grip = cosine * flank.trace.lever(s, self.size)
        grip = grip - load.friction_loss(sense, sine, s[0], np.abs)
        slow, fast = load.speeds
        with np.errstate(all="ignore"):
            turning = -load.damping * s[1] / (2.0 * load.mass * s[2])
        turning = np.where(np.isfinite(turning), np.clip(turning, slow, fast), slow)
        moved = [
            load.side * MILLI * (load.mass * w * w * s[2] + load.damping * w * s[1])
            for w in (slow, fast, turning)
        ]
        rest = load.side * (process + load.weight)
        return _Rows(
            load.side * s[0], rest + np.min(moved, axis=0), rest + np.max(moved, axis=0), grip
        )


def _spread(curve: Piecewise, count: int) -> tuple[Indices, Array]:
    """Points on every piece, ends included."""
    step = np.linspace(0.0, 1.0, count)
    x = (curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * step).ravel()
    return np.repeat(np.arange(curve.count), count), x
