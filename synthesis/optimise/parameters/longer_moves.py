"""Free angles where curvature decides: moves as long as a box allows bound all numbers in it.

The bound of ``parametric_bound`` leaves curved limits out. Here a box of angles is bounded by one
problem, with every limit that a problem has:

**Theorem.** Laws are those of which bounds speak: s'' continuous, the jerk capped. Let a box leave
law k an angle of at most B_k, each of these laws at rest at one of its ends: s' and s'' are known
to be 0 there. Then the problem with the angles B_k, whose sum may be more than a turn, has no
larger optimum than that of any angles in the box.

*Proof.* Take a cam with angles β_k ≤ B_k, and add a rest of B_k − β_k to the end of law k that is
at rest. The longer law has continuous s, s' and s'' and meets its neighbours as before; it is
monotone if it was; its jerk is 0 on the rest. All other limits and objectives speak of one cam
angle at a time: of s, s', s'', the size and the sense of the move. On the added rest these are what
they are at that end of the law, where the limits hold. Means over the turn gain nothing from a
rest. What speaks of the place on the cam is excluded: ``Placement`` refuses windows, vibration and
rows that change with the place, ``serves`` forces of the process that do. So the longer laws and
the same size satisfy the longer problem, with the same value. ∎

With the sum of angles given, no other numbers u have all angles larger than those at u*: in each,
one angle k is below u*_k, unless it is u* itself. So the boxes {u_k ≤ u*_k}, one for each angle
that is not at its least, hold all numbers; in each of them one law is as short as at u*, and all
others as long as they may be. If each law by itself decides how large the cam must be, the box of
law k has a bound of what that law asks for at u*_k: where these are equal, the bounds are those at
u* itself, and nothing is lost by the boxes. ``_balanced`` seeks such numbers. Where laws decide
together, in the offset for example, boxes have lower bounds, and are divided.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from heapq import heappop, heappush
from itertools import accumulate, count
from math import inf, log

import numpy as np
from scipy.optimize import brentq

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.driver import BUDGET, optimise
from synthesis.optimise.parameters.number_search import ALL_NUMBERS, Box, NumberProof
from synthesis.optimise.parameters.placement import Placement
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.state import ProofBudget, SolveState

JERK = 3  # order of the derivative
COARSE = 4  # intervals of laws of which only the ends are looked at
EQUAL = 0.1  # of the tolerance: by how much two laws may differ in what they ask for
EXCHANGES = 2  # between two angles, for each of them
ROUNDS = 2  # of proofs: the first ones find better cams, about which the next ones are
NEAR = 0.2  # of the box: a local optimum of laws so much longer or shorter is a start
CLOSEST = 1e-9  # of a turn: an angle is known no better
AHEAD = 0.9  # of what is missing: proofs also find better cams, which then ask for more
LEAST_SHARE = 0.2  # of the tolerance: no proof of a box is sought to less
ROUGH = 4.75e-3  # relative gap sought before a finer one: boxes take a third of the time
NOTHING = 1e30  # of the objective: a law for which there is no cam at all
LONGER = 1e-12  # relative: no rounding makes a longest angle shorter than one in its box


_Entry = tuple[float, int, Box]  # a bound, a number that orders equal ones, and its box


@dataclass(eq=False)
class LongerMoves:
    """Bounds of boxes of angles by problems with longer moves, and the best angles by these.

    Attributes:
        placement: where segments lie. solve_at: the search at single numbers to a gap.
        bound: a bound of a box that leaves curvature out, up to a target [core units].
        tolerance: relative gap [wire] at which to stop. single: that at single numbers.
        proof: what may be spent on each box.
        known: boxes' problems solved as they come, by the longest angles.
        asked: of every law the logarithm of what it asks for, by its number.
    """

    placement: Placement
    solve_at: Callable[[Array, float], SolveState | None]
    bound: Callable[[Box, float], tuple[float, Array]]
    tolerance: float
    single: float
    proof: ProofBudget
    searches: int = 0
    known: dict[bytes, SolveState] = field(default_factory=dict)
    asked: dict[int, dict[float, float]] = field(default_factory=dict)

    def serves(self) -> bool:
        """Whether the theorem holds: only angles are free, and every law of them can be longer."""
        problem, place = self.placement.problem, self.placement
        if np.any(place.lifts.slope) or np.any(place.polytope.matrix <= 0.0):
            return False
        load = problem.machine.load
        if load is not None and not load.process.is_constant:
            return False
        model = formulate(problem, [uniform_grid(s, COARSE) for s in problem.free])
        if {control.order for control in law_controls(model) or ()} != {JERK}:
            return False
        return all(
            k is None or _rests(boundary.start) or _rests(boundary.end)
            for k, boundary in zip(place.coordinates, model.boundary_states, strict=True)
        )

    @property
    def has_one_size(self) -> bool:
        """Whether one size is open, so that each law by itself decides how large it must be."""
        return sum(low != high for low, high in self.placement.problem.sizing.bounds) <= 1

    def problem(self, high: Array) -> Problem:
        """The problem with every free angle as long as at ``high``, which need not be a turn."""
        first, (_, longest) = self.placement.problem, self.placement.angles.range_over(high, high)
        angles = {
            s.index: float(angle) * (1.0 + LONGER)
            for s, angle, k in zip(first.free, longest, self.placement.coordinates, strict=True)
            if k is not None
        }
        every = [angles.get(s.index, s.angle) for s in first.segments]
        starts = accumulate(every[:-1], initial=0.0)
        placed = zip(first.segments, starts, every, strict=True)
        return replace(
            first, segments=tuple(replace(s, start=at, angle=angle) for s, at, angle in placed)
        )

    def run(self, start: Array, last_program: float, deadline: float) -> NumberProof | None:
        """The best angles from a start, and a bound over all of them; None where no cam is found.

        Args:
            start: numbers to begin with.
            last_program: ``clock.programs_solved()`` from which on no box is divided.
            deadline: ``clock.now()`` to stop at.
        """
        # 1. To a rough tolerance first: what asks for a finer one has that answer at least.
        found = None
        if self.tolerance < ROUGH:
            rough = replace(self, tolerance=ROUGH, single=self.single * ROUGH / self.tolerance)
            found = rough.run(start, last_program, deadline)
            self.searches = rough.searches
        u = self._balanced(start, deadline) if found is None else found.u
        # 2. Boxes about the best angles, as long as that gains.
        for _ in range(ROUNDS):
            best = self.solve_at(u, self.single)
            if best is None or best.incumbent is None:
                break
            proof, solved = self._prove(u, best, last_program, deadline)
            # The proofs find better cams than searches did, so that laws ask for other sizes.
            other = self._moved_by(u, solved)
            before, found = found, proof if found is None else found.combined(proof)
            closed = found.gap <= self.tolerance
            idle = before is not None and found.gap >= before.gap
            if closed or idle or other is None or clock.now() >= deadline:
                break
            u = other
        return found

    def _prove(
        self, u: Array, best: SolveState, last_program: float, deadline: float
    ) -> tuple[NumberProof, dict[int, SolveState]]:
        """The bound over all numbers from boxes about u, and the boxes' own problems by the law.

        ``best``: the search at u. The bound is −∞ where a box has none over all laws in time.
        """
        assert best.incumbent is not None
        order, heap, solved = count(), list[_Entry](), dict[int, SolveState]()
        # 1. Boxes that hold all numbers: in each one angle is no longer than at u.
        pruned, valid_for, why = inf, "", "no box has a better cam"
        value = self._wire(best, best.incumbent.value)
        cover = self._cover(u)
        for number, (k, box) in enumerate(cover):
            # Boxes share the time that is left.
            now = clock.now()
            state = self._bound(box, value, now + (deadline - now) / (len(cover) - number))
            if state.infeasibility_proof:
                continue
            lower = state.lower if state.covers_all_laws else -inf
            solved[k], valid_for = state, valid_for or state.valid_for
            heappush(heap, (lower, next(order), box))
        # 2. Each law from the box in which it decides: together they are a cam at u.
        best = best.with_incumbent(self._assembled(best, solved))
        assert best.incumbent is not None
        value = self._wire(best, best.incumbent.value)
        objective, machine = best.problem.objective, best.problem.machine
        target = objective.from_wire(value * (1.0 - self.tolerance), machine)
        while heap and heap[0][0] < target:
            if clock.now() >= deadline or clock.programs_solved() >= last_program:
                why = "time" if clock.now() >= deadline else BUDGET
                break
            # 3. Where laws decide together, narrower boxes have better bounds.
            lower, _, box = heappop(heap)
            for half in box.halves():
                inside = half.within(self.placement.polytope)
                if inside is None:
                    continue
                bound = max(lower, self.bound(inside, target)[0])
                if bound < target:
                    state = self._bound(inside, value, deadline)
                    own = state.lower if state.covers_all_laws else -inf
                    bound = inf if state.infeasibility_proof else max(bound, own)
                if bound >= target:
                    pruned = min(pruned, bound)
                else:
                    heappush(heap, (bound, next(order), inside))
        lower = min([pruned, best.incumbent.value, *(each[0] for each in heap)])
        proof = NumberProof(
            u, best.incumbent.value, lower, f"{valid_for}, {ALL_NUMBERS}",
            partial(best.gap_between, best.incumbent), self.searches, why, curved=True,
            cam=best.incumbent,
        )  # fmt: skip
        return proof, solved

    def _assembled(self, best: SolveState, solved: Mapping[int, SolveState]) -> Candidate:
        """Every law from the problem in which its angle is that of u, the size to suit all."""
        assert best.incumbent is not None
        cams = {k: state.incumbent for k, state in solved.items() if state.incumbent is not None}
        laws, size = list(best.incumbent.laws), best.incumbent.size
        for position, k in enumerate(self.placement.coordinates):
            if k in cams:
                laws[position] = cams[k].laws[position]
        return recover_cam(best.problem, laws, size)

    def _moved_by(self, u: Array, solved: Mapping[int, SolveState]) -> Array | None:
        """Numbers where laws ask for cams of equal size, by what proofs have shown of them.

        One step of Newton's method, with the slopes that searches near by have shown.
        """
        asked = {
            k: log(self._wire(state, state.incumbent.value))
            for k, state in solved.items()
            if state.incumbent is not None and len(self.asked.get(k, ())) > 1
        }
        if len(asked) < 2:
            return None
        most, least = max(asked, key=lambda k: asked[k]), min(asked, key=lambda k: asked[k])
        slopes = [self._slope(k, u[k]) / self._row[k] for k in (most, least)]
        excess = asked[most] - asked[least]
        if excess <= 2.0 * EQUAL * self.tolerance or sum(slopes) >= 0.0 or u[most] >= 1.0:
            return None
        room = min((1.0 - u[most]) * self._row[most], u[least] * self._row[least])
        return self._exchanged(u, most, least, min(-excess / sum(slopes), room))

    def _slope(self, k: int, at: float) -> float:
        """How what a law asks for changes with its number there, from the two nearest searches."""
        (x, y), (other, there) = sorted(self.asked[k].items(), key=lambda p: abs(p[0] - at))[:2]
        return (there - y) / (other - x)

    def _cover(self, u: Array) -> list[tuple[int, Box]]:
        """Boxes that hold all numbers, in each of which one angle is no longer than at u."""
        boxes = []
        for k in np.flatnonzero(u > 0.0):
            high = np.ones(len(u))
            high[k] = u[k]
            box = Box(np.zeros(len(u)), high).within(self.placement.polytope)
            if box is not None:
                boxes.append((int(k), box))
        return boxes

    def _bound(self, box: Box, value: float, deadline: float) -> SolveState:
        """A box's problem, solved to what is missing to the target; ``value``: of the best [wire].

        Its own cams say to which gap: what lies between the best of them and the target.
        """
        quick, least = self._quick(box, deadline), value * (1.0 - self.tolerance)
        if quick.incumbent is None or quick.suffices or self._wire(quick, quick.lower) >= least:
            return quick
        missing = 1.0 - least / self._wire(quick, quick.incumbent.value)
        enough = AHEAD * min(max(missing, LEAST_SHARE * self.tolerance), self.tolerance)
        self.searches += 1
        state = optimise(
            self.problem(box.high), enough, deadline, proof=self.proof,
            warm_start=quick.local_optimum,
        )  # fmt: skip
        if quick.covers_all_laws and state.covers_all_laws:  # of the same problem
            state = state.raise_bound(quick.lower, quick.valid_for)
        state = state.with_incumbent(quick.incumbent)
        self.known[box.high.tobytes()] = state
        return state

    def _quick(self, box: Box, deadline: float) -> SolveState:
        """A box's problem, solved as it comes from the nearest one's local optimum; once."""
        key = box.high.tobytes()
        if key not in self.known:
            distances = {at: np.max(np.abs(np.frombuffer(at) - box.high)) for at in self.known}
            near = min(distances, key=lambda at: distances[at], default=b"")
            begun = self.known[near].local_optimum if distances.get(near, inf) <= NEAR else None
            self.searches += 1
            self.known[key] = optimise(
                self.problem(box.high), self.single, deadline, warm_start=begun
            )
        return self.known[key]

    def _balanced(self, u: Array, deadline: float) -> Array:
        """Numbers at which laws ask for cams of equal size, as far as their ranges allow.

        The law that asks for the largest cam gets what the one that asks for the smallest can
        spare; the more angle, the less a law asks for (the theorem), so that what is equal lies
        between the ends, and a search for the zero of a difference finds it. Dwells ask for none.
        """
        laws = {k for k in self.placement.coordinates if k is not None}
        for _ in range(EXCHANGES * (len(u) - 1)):
            asked = {
                k: self._asked(k, u[k], deadline) if k in laws else -log(NOTHING)
                for k in range(len(u))
            }
            most = max(asked, key=lambda k: asked[k])
            least = min(asked, key=lambda k: asked[k] if u[k] > 0.0 else inf)
            equal = asked[most] - asked[least] <= EQUAL * self.tolerance
            if equal or u[most] >= 1.0 or u[least] <= 0.0 or clock.now() >= deadline:
                break
            room = min((1.0 - u[most]) * self._row[most], u[least] * self._row[least])

            def excess(step: float, u: Array = u, most: int = most, least: int = least) -> float:
                at = self._exchanged(u, most, least, step)
                other = self._asked(least, at[least], deadline) if least in laws else -log(NOTHING)
                more = self._asked(most, at[most], deadline) - other
                return 0.0 if abs(more) <= EQUAL * self.tolerance else more

            step = room if excess(room) >= 0.0 else brentq(excess, 0.0, room, xtol=CLOSEST)
            u = self._exchanged(u, most, least, float(step))
        return u

    @property
    def _row(self) -> Array:
        """Shares of a turn that the numbers are from 0 to 1: (n,)."""
        return np.asarray(self.placement.polytope.matrix[0])

    def _exchanged(self, u: Array, more: int, less: int, step: float) -> Array:
        """The numbers with a step, a share of the turn, given from one angle to another."""
        found = u.copy()
        found[more] += step / self._row[more]
        found[less] -= step / self._row[less]
        return np.asarray(np.clip(found, 0.0, 1.0))

    def _asked(self, k: int, longest: float, deadline: float) -> float:
        """The logarithm of what a law asks for at an angle, all others as long as they may be."""
        high = np.ones(len(self._row))
        high[k] = longest
        box = Box(np.zeros(len(high)), high).within(self.placement.polytope)
        state = None if box is None else self._quick(box, deadline)
        if state is None or state.incumbent is None:
            return log(NOTHING)
        asked = log(max(self._wire(state, state.incumbent.value), 1.0 / NOTHING))
        self.asked.setdefault(k, {})[longest] = asked
        return asked

    @staticmethod
    def _wire(state: SolveState, value: float) -> float:
        return state.problem.objective.to_wire(value, state.problem.machine)


def _rests(state: Array) -> bool:
    """Whether all derivatives below the jerk are known to be 0 at an end."""
    return len(state) >= JERK and not state[1:].any()
