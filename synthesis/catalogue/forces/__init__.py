"""Forces of a cam: what its follower carries, and what the cam has to do about it.

Symbols, used throughout (N, mm, kg, s; angles in rad; derivatives per radian of cam angle):

    m, c, k  mass, viscous damping and spring rate, reduced to the displacement s
    F0       preload: what the spring presses with at the lowest position
    P, W     process force and weight, both positive against the rise
    G        drive = m s'' ω² + c s' ω + k s ± F0 + P + W: what the cam gives along the motion
    N        contact force, along the common normal: G = N (n · g) λ, λ the contact's lever
    T        camshaft torque = N (n · g) λ s': without friction G s'
    p        Hertz pressure of the line contact

In: a load as on the wire (``load``, of the parts in ``load_parts`` and ``friction``). Out: the load
reduced to the displacement, and the forces over the turn (``reduced``, open it first).
"""

from typing import Annotated

from pydantic import Field

from synthesis.catalogue.forces.load import ArmLoad, Load, SlideLoad
from synthesis.catalogue.forces.reduced import ReducedLoad

AnyLoad = Annotated[SlideLoad | ArmLoad, Field(discriminator="kind")]

__all__ = ["AnyLoad", "ArmLoad", "Load", "ReducedLoad", "SlideLoad"]
