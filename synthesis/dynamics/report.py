"""TrainResponse: what is told of a follower train on its cam."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from synthesis.design import Design, told
from synthesis.dynamics.train import TrainSpec


class Told(BaseModel):
    """Something that is told: settled, without surprises."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Mode(Told):
    """A mode of the train, the cam standing still."""

    natural_frequency_hz: float = told("Undamped natural frequency; of a creeping mode, its rate.")
    damping_ratio: float = told("Damping as a share of the critical one; 1 where it creeps.")


class ResponsePeak(Told):
    """An extreme over the turn."""

    value: float = told("Its value.")
    angle_deg: float = told("Cam angle where it is.")


class DwellResponse(Told):
    """What swings on when a dwell begins, in the periodic response."""

    segment: int = told("Index of the dwell in the program.")
    start_deg: float = told("Cam angle where it begins.")
    modes: list[float] = told("Amplitude of the output in every mode, in the order of `modes`.")
    amplitude: float = told("Their sum: what the output can be off its place by.")
    alone: list[float] = told(
        "What the run of moves before it leaves of an oscillator with each mode's frequency and "
        "damping that was at rest before it: what the limit `residual_vibration` is about."
    )


class Flight(Told):
    """What becomes of a train that leaves its cam, integrated in time from rest."""

    first_lost_turn: int | None = told("Turn, from 0, in which contact is lost first; null: never.")
    first_lost_deg: float | None = told("Cam angle where.")
    losses: int = told("How often contact is lost in all turns.")
    in_air: float = told("Share of the last turn without contact.")
    largest_gap: float = told("Largest gap between cam and train.")
    contact_force_max_n: float = told("Largest contact force, landings included.")
    output_error_end: float = told("Output less cam at the end of the last turn.")
    uncertainty: float = told(
        "By how much that differs from an integration a hundred times as coarse; flights magnify "
        "any difference, so that single landings far on are not to be relied on where it is large."
    )
    rattles: bool = told("Given up after 400 losses of contact.")


class AtSpeed(Told):
    """The periodic response at one speed, and how it is reached from rest."""

    speed_rpm: float = told("Speed of the cam.")
    output_error_max: ResponsePeak = told("Output less the cam's motion, at its largest.")
    output_error_min: ResponsePeak = told("The same at its smallest.")
    output_acceleration_max: ResponsePeak = told(
        "Acceleration of the output at its largest, per s²."
    )
    output_acceleration_min: ResponsePeak = told("The same at its smallest.")
    contact_force_max_n: ResponsePeak = told("Largest force between cam and train.")
    contact_force_min_n: ResponsePeak = told(
        "Smallest; below 0 the linear train would pull at the cam."
    )
    floats: bool = told("The force that holds the train on the cam does not do: contact is lost.")
    dwells: list[DwellResponse] = told("What is left when each dwell begins.")
    remembers: float = told(
        "Share of a disturbance that is left after a turn; 1 without damping: then the periodic "
        "response is the one that repeats itself, but none is forgotten for it."
    )
    turns: list[float] = told(
        "From rest: largest distance of the output from the periodic response in every turn."
    )
    flight: Flight | None = told(
        "Where contact is lost: what becomes of the train in the `turns` asked for, from rest. "
        "Null where it is not lost, no turns are asked for, or the train swings too fast for that."
    )
    steps: int = told("Steps of the turn at whose ends the extremes were read.")
    rounding: float = told(
        "Estimate of what rounding makes of a deflection; there is no other error."
    )


class TrainResponse(Told):
    """The answer to a TrainSpec. Lengths are in `unit`: along the arc of an arm's end, mm too."""

    id: str = told("Hash of the spec and the engine's version.")
    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that made it.")
    unit: str = told("Unit of displacements: mm.")
    modes: list[Mode] = told("The train's modes, slowest first.")
    speeds: list[AtSpeed] = told("Speed by speed, as asked.")
    float_onset_rpm: float | None = told(
        "Speed at which contact is first lost between two of the speeds asked; null where it "
        "is not, or is already at the slowest, or where the cam holds both ways."
    )
    cam: Design = told("The cam.")
    spec: TrainSpec = told("The question.")
    links: dict[str, str] = Field({}, description="Where to find its files.")
