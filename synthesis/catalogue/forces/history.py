"""The course of all forces over the turn, from the follower's closed forms.

The certificate takes its geometry from the traced path instead; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.forces.reduced import (
    MILLI,
    ContactState,
    ReducedLoad,
    face_pressure_square,
    pressure_square,
)
from synthesis.catalogue.motion import Motion, within_turn
from synthesis.numerics.piecewise import Array, Side


@dataclass(frozen=True, eq=False)
class ForceHistory:
    """Forces at n cam angles, rigid bodies at constant speed; arrays are (n,).

    Attributes:
        theta: [rad]. s: (4, n) s to s''' [mm, per rad].
        inertia, damping, spring, process: the parts of the drive, weight with the process [N].
        drive: G, their sum. friction: along the slide [N].
        torque: T on the camshaft [N m].
        contact: by flank, its force where it is pressed; negative where it is not [N].
        pressure: by flank, 0 where it is not pressed [MPa]; empty without a line contact.
        rolling: by flank, how fast a roller on it turns on its pin [rad/s]; of rollers only. In a
            groove it turns the other way on the other flank.
    """

    theta: Array
    s: Array
    inertia: Array
    damping: Array
    spring: Array
    process: Array
    drive: Array
    friction: Array
    torque: Array
    contact: Mapping[str, Array]
    pressure: Mapping[str, Array]
    rolling: Mapping[str, Array]


def history(
    follower: Follower,
    load: ReducedLoad,
    omega: float,
    motion: Motion,
    size: tuple[float, ...],
    theta: ArrayLike,
    side: Side = "right",
) -> ForceHistory:
    """Forces on a finished cam.

    Args:
        follower: as built. load: reduced to its displacement. omega: cam speed [rad/s].
        motion, size: the finished cam. theta: (n,) cam angles in the turn [rad].
        side: which value to give where the acceleration or the process force jumps.
    """
    angle = np.asarray(theta, dtype=float).ravel()
    s, wrapped = motion.derivatives(angle, 3, side), within_turn(angle, side)
    process = load.process(wrapped, 0, side)
    # Friction acts against the motion of the segment that the angle lies in.
    placed = [segment for segment in motion.segments if segment.angle > 0.0]
    starts = np.array([segment.start for segment in placed])
    which = np.clip(np.searchsorted(starts, wrapped, side=side) - 1, 0, None)
    sense = np.array([load.sliding_sense(segment) for segment in placed])[which]
    places = dict[str, ContactState]()
    for flank in follower.flanks:
        sine, cosine = pressure_angle_sine_cosine(flank.trace, s, size)
        lever = flank.trace.lever(s, size)
        places[flank.name] = ContactState(
            load, omega, tuple(s), process, sense, sine, cosine, lever
        )
    first = next(iter(places.values()))
    contact = {
        flank.name: flank.side * places[flank.name].contact_force() for flank in follower.flanks
    }
    resisted = load.friction_loss(sense, first.sine, s[0], np.abs) * np.ones_like(angle)
    return ForceHistory(
        theta=angle,
        s=s,
        inertia=load.mass * omega * omega * MILLI * s[2],
        damping=load.damping * omega * MILLI * s[1],
        spring=load.rate * s[0] + load.side * load.preload,
        process=process + load.weight,
        drive=first.drive(),
        friction=first.contact_force() * resisted,
        torque=first.torque(),
        contact=contact,
        pressure={
            flank.name: _pressure(flank, follower, load, contact[flank.name], s, size)
            for flank in follower.flanks
            if load.contact is not None and (flank.roller > 0.0 or follower.always_convex)
        },
        rolling={
            flank.name: _rolling(flank, omega, s, size)
            for flank in follower.flanks
            if flank.roller > 0.0
        },
    )


def _pressure(
    flank: Flank,
    follower: Follower,
    load: ReducedLoad,
    pressed: Array,
    s: Array,
    size: tuple[float, ...],
) -> Array:
    numerator, square = flank.trace.curvature_terms(s, size)
    with np.errstate(divide="ignore", invalid="ignore"):
        if follower.always_convex:
            found = face_pressure_square(load, pressed, numerator / np.sqrt(square))
        else:
            found = pressure_square(load, flank, flank.side * pressed, numerator / square**1.5)
    return np.asarray(np.sqrt(np.maximum(found, 0.0)))


def _rolling(flank: Flank, omega: float, s: Array, size: tuple[float, ...]) -> Array:
    """How fast a roller that does not slip turns on its pin [rad/s].

    On the cam its centre moves at W per radian, so there it turns by W/Rr; the cam turns by one
    and, on an arm, the pin by as much as the direction of drive.
    """
    _, square = flank.trace.curvature_terms(s, size)
    (gx, gy), (hx, hy) = flank.trace.drive_direction(s, size)
    pin = gx * hy - gy * hx
    return np.asarray(np.abs(flank.side * np.sqrt(square) / flank.roller - 1.0 + pin) * omega)
