"""Whether shaft, hub, keyway and base radius of a spec suit each other."""

from __future__ import annotations

from pydantic_core import PydanticCustomError

from synthesis.catalogue.followers import Follower
from synthesis.catalogue.hub import HUB_RULE, KEYED_BORES, keyway_reach


def check_shaft(
    follower: Follower, shaft: float | None, hub: float | None, largest: float, *, keyway: bool
) -> None:
    """Refuse a shaft whose hub does not fit.

    Args:
        follower: whose cam has a hub unless it is a ring. shaft: its diameter [mm]. hub: its own
            or by the rule. largest: base radius that the spec allows. keyway: whether there is one.
    """
    if hub is not None and all(flank.side < 0 for flank in follower.flanks):
        raise PydanticCustomError(
            "ring_has_no_hub",
            "The cam is touched from inside: it is a ring, with no material round its axis. Leave "
            "shaft_diameter_mm, hub_diameter_mm and keyway out.",
        )
    reach, what = shaft or 0.0, "the shaft"
    if keyway:
        if shaft is None:
            raise PydanticCustomError(
                "keyway_without_shaft",
                "A keyway is asked for, but no shaft. Give shaft_diameter_mm.",
            )
        corner = keyway_reach(shaft)
        if not corner:
            raise PydanticCustomError(
                "keyway_has_no_standard",
                "shaft_diameter_mm = {value}: {rule} Leave keyway out, or change the shaft.",
                {"value": shaft, "rule": KEYED_BORES},
            )
        reach, what = 2.0 * corner, "the keyway"
    if hub is None:
        return
    if hub <= reach:
        raise PydanticCustomError(
            "hub_too_small",
            "hub_diameter_mm = {value} leaves no material round {what}, which reaches {reach} mm "
            "across. Give a larger hub, or leave it out: then it is {rule}.",
            {"value": hub, "what": what, "reach": float(f"{reach:.6g}"), "rule": HUB_RULE},
        )
    if largest < 0.5 * hub:
        raise PydanticCustomError(
            "base_radius_inside_hub",
            "base_radius_mm = {value} lies inside the hub, whose radius is {radius} mm. Allow a "
            "larger base radius, or give a smaller shaft_diameter_mm or hub_diameter_mm.",
            {"value": largest, "radius": 0.5 * hub},
        )
