"""Polydyne cams: the cam motion for which an elastic train's output moves exactly as prescribed.

Without dampers in the links, the force on a mass, m x'' + c_g x' + k_g x, gives the elongation of
its link and so the displacement of the mass before it. Recursively, the cam's motion is a
polynomial in d/dt applied to the output's; n masses take 2n derivatives (Dudley, 1948; Stoddart,
Machine Design 25, 1953).
"""

from __future__ import annotations

import numpy as np

from synthesis.catalogue.motion import Motion
from synthesis.errors import InputError
from synthesis.machines.dynamics.chain import Chain
from synthesis.machines.dynamics.response import derivative_jumps
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

JUMP = 1e-7  # of the largest value of a derivative: smaller jumps are rounding
NAMES = ("displacement", "velocity", "acceleration", "jerk", "snap")


def factors(chain: Chain) -> Array:
    """Coefficients of the output's time derivatives in the cam's motion: (2n+1,)."""
    n = chain.count
    after, here = np.zeros(2 * n + 1), np.eye(1, 2 * n + 1)[0]
    for i in reversed(range(n)):
        force = chain.ground_springs[i] * here + chain.ground_dampers[i] * np.roll(here, 1)
        force = force + chain.masses[i] * np.roll(here, 2)
        if i + 1 < n:
            force = force + chain.springs[i + 1] * (here - after)
        after, here = here, here + force / chain.springs[i]
    return np.asarray(here)


def polydyne(chain: Chain, output: Motion, omega: float, theta: Array) -> Array:
    """The cam motion under which the last mass moves as ``output`` says, at ω [rad/s].

    Returns s, s' and s'' of the cam, per radian, at cam angles (k,) [rad]: (3, k) [mm].

    Raises:
        InputError: a link has a damper, or the output is not smooth enough: the cam's velocity
            would jump.
    """
    if chain.dampers.any():
        position = int(np.flatnonzero(chain.dampers)[0])
        raise InputError(
            f"/train/masses/{position}/damping_n_s_per_mm", float(chain.dampers[position]),
            "Only without dampers in the links has the cam motion for an output a closed form.",
            "Leave the damper out, or give it as ground_damping_n_s_per_mm.",
        )  # fmt: skip
    orders = 2 * chain.count + 1
    for order in range(1, orders + 1):
        jumps = derivative_jumps(output.curve, order, JUMP)
        if jumps.any():
            at = float(output.curve.breaks[int(np.argmax(np.abs(jumps)))]) / DEGREE
            name = NAMES[order] if order < len(NAMES) else f"derivative {order}"
            raise InputError(
                "/cam/program", round(at, 6),
                f"The {name} of the output jumps at {at:.6g}°, so the cam's motion would not be "
                f"smooth: {orders} derivatives of the output must be continuous.",
                "Choose smoother laws (polynomial_4_5_6_7 has 3 continuous derivatives, "
                "polynomial_6_7_8_9_10_11 has 5) or fewer masses.",
            )  # fmt: skip
    by_angle = factors(chain) * omega ** np.arange(orders)
    derivatives = output.derivatives(theta, orders + 1)
    return np.stack([by_angle @ derivatives[k : k + orders] for k in range(3)])
