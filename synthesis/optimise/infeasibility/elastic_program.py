"""The cone program of a scene some of whose parts may give way, at a price.

Every row belongs to a part or to nobody. A part that gives way by v moves the right sides of its
rows by v times what each gives; a part that is dropped loses its rows.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeProgram, solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.infeasibility.relaxable import Relaxable, RelaxableRange

NOBODY = -1
UNITS = (1.0, 1e4, 1e8)
AMPLE = 1e4  # of a unit: what gives way by more is not told exactly in it


@dataclass(frozen=True, eq=False)
class Rows:
    """Left sides matrix · x and right sides; of every row whose it is and how much it gives.

    Attributes:
        cones: sizes of the second-order cones that the rows form, () for plain rows.
    """

    matrix: sparse.csr_matrix
    rhs: Array
    owner: NDArray[np.intp]
    give: Array
    cones: tuple[int, ...] = ()

    def and_then(self, other: Rows) -> Rows:
        """These rows and others below."""
        return Rows(
            sparse.csr_matrix(sparse.vstack([self.matrix, other.matrix])),
            np.concatenate([self.rhs, other.rhs]),
            np.concatenate([self.owner, other.owner]),
            np.concatenate([self.give, other.give]),
            self.cones + other.cones,
        )

    def without(self, dropped: Collection[int]) -> Rows:
        """The rows of all other parts."""
        kept = ~np.isin(self.owner, list(dropped))
        heads = np.cumsum((0, *self.cones))[:-1]
        cones = tuple(n for n, head in zip(self.cones, heads, strict=True) if kept[head])
        return Rows(self.matrix[kept], self.rhs[kept], self.owner[kept], self.give[kept], cones)

    def columns(self, loose: Sequence[int]) -> sparse.csr_matrix:
        """One column for every part that may give way."""
        table = np.zeros((len(self.rhs), len(loose)))
        for column, part in enumerate(loose):
            mine = self.owner == part
            table[mine, column] = -self.give[mine]
        return sparse.csr_matrix(table)


@dataclass(frozen=True, eq=False)
class Statement:
    """All rows of a model and of the ranges of its size."""

    equal: Rows
    unequal: Rows
    conic: Rows

    def excess(self, x: Array) -> Array:
        """Left sides less right sides of the inequalities."""
        return np.asarray(self.unequal.matrix @ x - self.unequal.rhs, dtype=float)

    def giving(self, part: int, looser: Statement, step: float, x: Array) -> Statement:
        """Rows that give by 1 what the part's value, doubled, would be worth to them at x.

        Args:
            part: which. looser: the same rows with its value higher by ``step``, relative.
            x: the point.
        """
        mine = self.unequal.owner == part
        if not np.any(mine):
            return self
        gained = (self.excess(x) - looser.excess(x))[mine] / step
        give = self.unequal.give.copy()
        give[mine] = np.maximum(gained, 1e-3 * float(gained.max()))
        return replace(self, unequal=replace(self.unequal, give=give))


@dataclass(frozen=True, eq=False)
class ElasticSolution:
    """A point of the model (without its extra unknown), and how far each loose part gave way.

    ``direction`` is the one in which the size had to be large, if it had to.
    """

    x: Array
    amounts: Array
    direction: Array | None

    @property
    def total(self) -> float:
        """How far all of them together."""
        return float(self.amounts.sum())


def state(
    model: ConicModel, parts: Sequence[Relaxable], direction: Array | None, tighten: float = 0.0
) -> Statement:
    """Whose the model's rows are, and the rows of the size's ranges.

    Args:
        model: of the problem with its size open.
        parts: what may give way.
        direction: unit vector y; where ‖z‖ must be large, y · z ≤ ‖z‖ stands in for it;
            None where that is not asked.
        tighten: relative amount by which the largest prime radius is drawn in.
    """
    position = {
        part.name: k for k, part in enumerate(parts) if not isinstance(part, RelaxableRange)
    }
    program = model.program
    matrix = sparse.csr_matrix(program.matrix)[:, : model.size.stop]
    first, stop = program.equalities, program.equalities + program.inequalities
    counts = [len(block.rhs) for block in model.blocks]
    owner = np.repeat([position.get(block.source, NOBODY) for block in model.blocks], counts)
    give = np.repeat([_natural(block) for block in model.blocks], counts)
    sizes = program.cones
    owner_conic = np.repeat(
        [position.get(ball.source, NOBODY) for ball in model.cone_blocks], sizes
    )
    heads = [
        np.append(ball.relaxation_unit, np.zeros(len(ball.shift))) for ball in model.cone_blocks
    ]
    give_conic = np.concatenate([np.zeros(0), *heads])
    equal = Rows(matrix[:first], program.rhs[:first], np.full(first, NOBODY), np.zeros(first))
    unequal = Rows(matrix[first:stop], program.rhs[first:stop], owner, give)
    conic = Rows(matrix[stop:], program.rhs[stop:], owner_conic, give_conic, sizes)
    for k, part in enumerate(parts):
        if isinstance(part, RelaxableRange):
            unequal = unequal.and_then(_ends(model, k, part, direction))
            conic = conic.and_then(_within(model, k, part, tighten))
    return Statement(equal, unequal, conic)


def _natural(block: LinearBlock) -> float:
    """What a block gives for one unit: the limit itself, or a slope times the unit of size.

    A window or a point gives in units of a good law.
    """
    if block.spans is not None:
        return 1.0
    slopes = np.abs(block.size[block.size != 0.0])
    return float(slopes.min()) if len(slopes) else float(np.max(np.abs(block.rhs)))


def _ends(model: ConicModel, position: int, part: RelaxableRange, direction: Array | None) -> Rows:
    """The ends of a range that are half-planes."""
    width, unit = model.size.stop, model.scales.size
    norm = model.problem.machine.follower.radius_norm()
    table, rhs, give = [], [], []
    for sign, end in ((1.0, part.high), (-1.0, part.low)):
        row = np.zeros(width)
        if part.axis is not None and abs(end) < inf:
            row[model.size.start + part.axis] = sign
            rhs.append(sign * end / unit)
            give.append(max(model.problem.length, abs(end)) / unit)
        elif part.axis is None and sign < 0.0 and part.low > 0.0 and direction is not None:
            row[model.size] = -(direction @ np.array(norm.matrix)) * unit / part.low
            rhs.append(float(direction @ np.array(norm.shift)) / part.low - 1.0)
            give.append(1.0)
        else:
            continue
        table.append(row)
    matrix = sparse.csr_matrix(np.array(table).reshape(len(table), width))
    return Rows(matrix, np.array(rhs), np.full(len(rhs), position), np.array(give))


def _within(model: ConicModel, position: int, part: RelaxableRange, tighten: float) -> Rows:
    """The largest prime radius: ‖z‖ ≤ high, divided by high."""
    norm = model.problem.machine.follower.radius_norm()
    count = len(norm.shift) + 1
    table = np.zeros((count, model.size.stop))
    if part.axis is not None or part.high == inf:
        none = np.zeros(0)
        return Rows(sparse.csr_matrix(table[:0]), none, np.zeros(0, dtype=np.intp), none)
    tighten = 0.0 if part.low == part.high else tighten
    table[1:, model.size] = -np.array(norm.matrix) * model.scales.size / part.high
    rhs = np.array([1.0 - tighten, *np.array(norm.shift) / part.high])
    give = np.array([1.0, *np.zeros(count - 1)])
    return Rows(sparse.csr_matrix(table), rhs, np.full(count, position), give, (count,))


def solve_elastic_program(
    stated: Statement,
    loose: Sequence[int],
    dropped: Collection[int] = (),
    floor: float = 0.0,
    direction: Array | None = None,
) -> ElasticSolution | None:
    """The point where the loose parts give way least in all; None where that does not help.

    Args:
        stated: the rows.
        loose: parts that may give way; all others may not.
        dropped: parts left out.
        floor: the least that each may give way, 0 or negative.
        direction: with which they were stated.
    """
    best: ElasticSolution | None = None
    for unit in UNITS:  # what has to give way by far is told in units of as much
        found, stopped = _in_units(stated, loose, dropped, floor, direction, unit)
        if stopped is StopReason.INFEASIBLE:
            break
        best = found or best
        if found is not None and np.max(found.amounts, initial=0.0) <= AMPLE * unit:
            break
    return best


def _in_units(
    stated: Statement,
    loose: Sequence[int],
    dropped: Collection[int],
    floor: float,
    direction: Array | None,
    unit: float,
) -> tuple[ElasticSolution | None, StopReason]:
    unequal, conic = stated.unequal.without(dropped), stated.conic.without(dropped)
    width, count = stated.equal.matrix.shape[1], len(loose)
    below = sparse.hstack([sparse.csr_matrix((count, width)), -sparse.eye(count)])
    blocks = [
        sparse.hstack([rows.matrix, unit * rows.columns(loose)]) for rows in (stated.equal, unequal)
    ]
    cones = sparse.hstack([conic.matrix, unit * conic.columns(loose)])
    rhs = (stated.equal.rhs, unequal.rhs, np.full(count, -floor / unit), conic.rhs)
    program = ConeProgram(
        sparse.csc_matrix((width + count, width + count)),
        np.concatenate([np.zeros(width), np.ones(count)]),
        sparse.csc_matrix(sparse.vstack([*blocks, below, cones])),
        np.concatenate(rhs),
        len(stated.equal.rhs),
        len(unequal.rhs) + count,
        conic.cones,
    )
    found = solve(program)
    if found.stopped not in USABLE:
        return None, found.stopped
    return ElasticSolution(found.x[:width], unit * found.x[width:], direction), found.stopped
