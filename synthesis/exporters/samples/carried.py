"""The forces of a design at the rows of a table or a diagram, one-sided where the motion jumps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from synthesis.catalogue.followers.flank import labelled
from synthesis.catalogue.forces.history import ForceHistory, history
from synthesis.design.design import Design
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.columns import Column
from synthesis.exporters.samples.sampling import Rows, table_rows
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class Carried:
    """What the cam of a design bears, at rows.

    Attributes:
        right, left: forces as limits from the right and from the left.
    """

    rows: Rows
    right: ForceHistory
    left: ForceHistory

    def value(self, of: Array, before: Array) -> Array:
        """A force at every row, from the side that the row is of."""
        found = of.copy()
        found[self.rows.left] = before[self.rows.left]
        return found

    @property
    def torque(self) -> Array:
        """T [N m]."""
        return self.value(self.right.torque, self.left.torque)

    @property
    def drive(self) -> Array:
        """G [N]."""
        return self.value(self.right.drive, self.left.drive)

    def contact(self) -> Iterator[tuple[str, Array]]:
        """Every flank's name and contact force [N]."""
        for name, force in self.right.contact.items():
            yield name, self.value(force, self.left.contact[name])

    def pressure(self) -> Iterator[tuple[str, Array]]:
        """Every flank's name and Hertz pressure [MPa], where a line contact is told of."""
        for name, pressure in self.right.pressure.items():
            yield name, self.value(pressure, self.left.pressure[name])


def carried(design: Design, cam: Cam, options: MotionOptions) -> Carried | None:
    """The forces of a design's cam at the rows of a table; None where no load is told."""
    machine = design.completed_spec.machine()
    if machine.load is None:
        return None
    rows = table_rows(cam, options)
    right, left = (
        history(
            machine.follower, machine.load, machine.omega, cam.motion, cam.size, rows.theta, side
        )
        for side in ("right", "left")
    )
    return Carried(rows, right, left)


def force_columns(design: Design, cam: Cam, options: MotionOptions) -> list[Column]:
    """Columns of forces for tables of the motion; none where no load is told."""
    found = carried(design, cam, options)
    if found is None:
        return []
    return [
        Column("drive_n", "N", "force that the cam gives along the motion", found.drive),
        Column("torque_n_m", "N m", "torque on the camshaft", found.torque),
        *(
            Column(
                f"{labelled('contact_force', name)}_n", "N",
                "force along the common normal; negative where the flank does not touch", force,
            )
            for name, force in found.contact()
        ),
        *(
            Column(f"{labelled('hertz_pressure', name)}_mpa", "MPa", "Hertz pressure", pressure)
            for name, pressure in found.pressure()
        ),
    ]  # fmt: skip
