"""Report on the forces of a finished cam."""

from __future__ import annotations

from synthesis.catalogue.fields import AnswerModel, doc


class ForcePeak(AnswerModel):
    """A largest or smallest value, proven for every cam angle."""

    value: float = doc("The value.")
    angle_deg: float = doc("Cam angle where it is reached.")
    width: float = doc("Width of the proven enclosure of the value.")


class FlankForces(AnswerModel):
    """What one flank of the cam bears."""

    flank: str = doc("Name of the flank; empty where the cam has one.")
    largest_n: ForcePeak | None = doc("Largest contact force; null where it is infinite.")
    smallest_n: ForcePeak | None = doc(
        "Smallest contact force: where it is not positive, this flank does not touch."
    )
    largest_pressure_mpa: ForcePeak | None = doc(
        "Largest Hertz pressure; null where it is infinite or no line contact is given."
    )


class Torque(AnswerModel):
    """Torque on the camshaft at constant speed, positive where the cam has to be driven."""

    largest_n_m: ForcePeak | None = doc("Largest torque; null where it is infinite.")
    smallest_n_m: ForcePeak | None = doc(
        "Smallest torque, negative where the cam drives its shaft."
    )
    mean_n_m: float = doc("Mean over the turn.")
    rms_n_m: float = doc("Root mean square over the turn.")
    power_w: float = doc("Mean power at the camshaft.")
    work_j: float = doc("Work of the camshaft in one turn: mean torque times 2π.")
    process_work_j: float = doc("Work done against the process force in one turn.")
    loss_j: float = doc("Work lost to damping and friction in one turn.")
    balance_error_j: float = doc("What these three differ by: rounding, and nothing else.")


class FloatArc(AnswerModel):
    """Where a force-closed follower leaves its cam: the contact force would have to be negative."""

    start_deg: float = doc("Cam angle where contact is lost.")
    end_deg: float = doc("Cam angle where the force is positive again.")
    lowest_n: float = doc("Lowest contact force on the way, which the spring lacks.")
    angle_deg: float = doc("Cam angle of the lowest.")


class RollerLife(AnswerModel):
    """How a roller turns, and how long its bearing lasts."""

    path: str = doc("Which roller; empty where there is one.")
    mean_speed_rpm: float = doc("Mean speed on its pin, rolling without slip.")
    largest_speed_rpm: float = doc("Largest speed on its pin.")
    equivalent_load_n: float | None = doc("Constant load of the same life; null: no bearing given.")
    life_million_turns: float | None = doc("L10 in million turns of the roller.")
    life_hours: float | None = doc("L10 in hours.")


class Forces(AnswerModel):
    """Rigid-body forces of the finished cam at its speed."""

    flanks: list[FlankForces] = doc("What each flank bears.")
    torque: Torque = doc("Torque on the camshaft.")
    floats: list[FloatArc] = doc("Where the follower leaves its cam; empty where it never does.")
    float_onset_rpm: float | None = doc(
        "Lowest speed from which it leaves its cam somewhere; null: at none up to a million times "
        "the cam's, or it is pushed both ways."
    )
    changes_flank_deg: list[float] = doc(
        "Cam angles at which a follower that is pushed both ways changes from one flank to the "
        "other."
    )
    rollers: list[RollerLife] = doc("The rollers.")
