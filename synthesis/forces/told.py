"""What is told of the forces of a finished cam."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


def told(description: str) -> Any:
    """A required field with its description in the contract."""
    return Field(description=description)


class Told(BaseModel):
    """A part of what is told."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class ForcePeak(Told):
    """A largest or smallest value, proven for every cam angle."""

    value: float = told("The value.")
    angle_deg: float = told("Cam angle where it is reached.")
    width: float = told("Width of the proven enclosure of the value.")


class FlankForces(Told):
    """What one flank of the cam bears."""

    flank: str = told("Name of the flank; empty where the cam has one.")
    largest_n: ForcePeak | None = told("Largest contact force; null where it is infinite.")
    smallest_n: ForcePeak | None = told(
        "Smallest contact force: where it is not positive, this flank does not touch."
    )
    largest_pressure_mpa: ForcePeak | None = told(
        "Largest Hertz pressure; null where it is infinite or no line contact is told of."
    )


class Torque(Told):
    """Torque on the camshaft at constant speed, positive where the cam has to be driven."""

    largest_n_m: ForcePeak | None = told("Largest torque; null where it is infinite.")
    smallest_n_m: ForcePeak | None = told(
        "Smallest torque, negative where the cam drives its shaft."
    )
    mean_n_m: float = told("Mean over the turn.")
    rms_n_m: float = told("Root mean square over the turn.")
    power_w: float = told("Mean power at the camshaft.")
    work_j: float = told("Work of the camshaft in one turn: mean torque times 2π.")
    process_work_j: float = told("Work done against the process force in one turn.")
    loss_j: float = told("Work lost to damping and friction in one turn.")
    imbalance_j: float = told("What these three differ by: rounding, and nothing else.")


class FloatArc(Told):
    """Where a force-closed follower leaves its cam: the contact force would have to be negative."""

    start_deg: float = told("Cam angle where contact is lost.")
    end_deg: float = told("Cam angle where the force is positive again.")
    lowest_n: float = told("Lowest contact force on the way, which the spring lacks.")
    angle_deg: float = told("Cam angle of the lowest.")


class RollerLife(Told):
    """How a roller turns, and how long its bearing lasts."""

    path: str = told("Which roller; empty where there is one.")
    mean_speed_rpm: float = told("Mean speed on its pin, rolling without slip.")
    largest_speed_rpm: float = told("Largest speed on its pin.")
    equivalent_load_n: float | None = told("Constant load of the same life; null: no bearing told.")
    life_million_turns: float | None = told("L10 in million turns of the roller.")
    life_hours: float | None = told("L10 in hours.")


class Forces(Told):
    """Rigid-body forces of the finished cam at its speed."""

    flanks: list[FlankForces] = told("What each flank bears.")
    torque: Torque = told("Torque on the camshaft.")
    floats: list[FloatArc] = told("Where the follower leaves its cam; empty where it never does.")
    floats_from_rpm: float | None = told(
        "Lowest speed from which it leaves its cam somewhere; null: at none up to a million times "
        "the cam's, or it is pushed both ways."
    )
    changes_flank_deg: list[float] = told(
        "Cam angles at which a follower that is pushed both ways changes from one flank to the "
        "other."
    )
    rollers: list[RollerLife] = told("The rollers.")
