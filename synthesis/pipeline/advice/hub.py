"""Whether a shaft and its hub fit into the base circle."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Final

from synthesis.catalogue.hub import HUB_RULE, hub_diameter, keyway_reach, shaft_of_hub
from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

# In a shaft with a keyway by the ASME code: 0.75 of the lesser of 0.18 · 300 N/mm², the strength of
# a mild steel, and 0.3 of its yield point, which is above 180 N/mm².
SHEAR_MPA: Final = 40.0
# Rothbart gives a hub of cast iron a number, and of one of steel says "slightly less": this share,
# as MITCalc has 1.6 to 1.8 shaft diameters of steel against 1.8 to 2 of cast iron. Steel: from
# 7500 kg/m³ on, between cast iron (7300 at most) and steel (7800 at least).
STEEL, STEEL_DENSITY = 0.9, 7500.0
THIN, THINNER = 0.2, 0.1  # shaft that the base circle leaves room for, over stroke


def _find(subject: Subject) -> Iterator[Finding]:
    if not subject.is_touched_from_outside:
        return
    radius, stroke, field = subject.base_radius, subject.stroke, "base_radius_mm"
    given, body, loaded = subject.spec.shaft_diameter_mm, subject.spec.body, _loaded(subject)
    bore = 0.0 if body is None else body.bore_mm or 0.0
    shaft, why = max(loaded, (bore, " (the bore of body)"))
    hub, room = hub_diameter(shaft), max(shaft_of_hub(2.0 * radius), 0.0)
    is_steel = body is None or body.density_kg_per_m3 >= STEEL_DENSITY
    least = STEEL * hub if is_steel else hub
    if radius <= 0.5 * shaft:
        yield Finding(
            "stop", field,
            f"The base radius of {number(radius)} mm lies inside the shaft of "
            f"{number(shaft)} mm diameter{why}.",
            f"Ask for a base radius of at least {number(0.5 * hub)} mm.",
        )  # fmt: skip
    elif given is not None and given < loaded[0]:
        yield Finding(
            "caution", "shaft_diameter_mm",
            f"The shaft of {number(given)} mm diameter is thinner than that of "
            f"{number(loaded[0])} mm{loaded[1]}.",
            f"Give a shaft of {number(loaded[0])} mm or more, or lower the load.",
        )  # fmt: skip
    elif radius <= (reach := keyway_reach(bore)):
        yield Finding(
            "caution", "body/bore_mm",
            f"The wall between the bore of {number(bore)} mm and the base circle is "
            f"{number(radius - 0.5 * bore)} mm; the keyway of that bore would reach "
            f"{number(reach)} mm from the axis, through it.",
            f"Ask for a base radius of at least {number(0.5 * hub_diameter(bore))} mm, take a "
            "thinner shaft, or make cam and shaft in one piece.",
        )  # fmt: skip
    elif subject.base_radius_is_set:
        return
    elif radius < 0.5 * hub and shaft > 0.0:
        is_thin = radius < 0.5 * least
        yield Finding(
            "caution" if is_thin else "note", field,
            f"A shaft of {number(shaft)} mm diameter{why} asks for a hub of {number(hub)} mm in "
            f"cast iron, about {number(STEEL * hub)} mm in steel; the base circle has "
            f"{number(2.0 * radius)} mm.",
            "Give the shaft (shaft_diameter_mm) or a base radius of at least "
            f"{number(0.5 * (least if is_thin else hub))} mm; or make cam and shaft in one piece.",
        )  # fmt: skip
    elif room < THIN * stroke:
        left = f"a shaft of {number(room)} mm diameter" if room > 0.0 else "no shaft"
        yield Finding(
            "stop" if room < THINNER * stroke else "caution", field,
            f"The base radius of {number(radius)} mm leaves room for {left}, against a stroke of "
            f"{number(stroke)} mm.",
            "Give the shaft (shaft_diameter_mm), or a least base radius that suits it: "
            f'base_radius_mm {{"min": …}}, half of the hub\'s {HUB_RULE}.',
        )  # fmt: skip


def _loaded(subject: Subject) -> tuple[float, str]:
    """Least diameter of the shaft under the load [mm], and how it is known; 0 without a load."""
    forces = subject.design.forces
    peaks = () if forces is None else (forces.torque.largest_n_m, forces.torque.smallest_n_m)
    torque = max((abs(peak.value) for peak in peaks if peak is not None), default=0.0)
    if torque <= 0.0:
        return 0.0, ""
    # τ = 16 T/(π d³), T in N mm
    diameter = (16.0 * 1e3 * torque / (pi * SHEAR_MPA)) ** (1.0 / 3.0)
    return diameter, f" (which the largest torque of {number(torque)} N m needs)"


RULE = Rule(
    code="hub",
    thresholds="stop: the base circle inside the bore, or inside the shaft that the load needs, "
    "the thinnest that carries the largest torque at 40 N/mm²; caution: a given shaft that is "
    f"thinner than that, a base circle below the hub of these ({HUB_RULE}; below "
    f"{STEEL:g} of that where the body is of steel or not given, and a note up to all of it), or a "
    "bore whose keyway by DIN 6885-1 would come out of the base circle. And by size alone: caution "
    "where the shaft for which this rule leaves room is thinner than a fifth of the stroke, stop: "
    "than a tenth.",
    reason="The cam has to be fixed on a shaft, and a key needs material round it.",
    source="Cam Design Handbook (Rothbart, ed., 2004), section 6.4.4, eq. 6.21: hub of cast iron, "
    "of steel slightly less; MITCalc, shaft connections: keyed hubs of steel 1.6 to 1.8 shaft "
    "diameters, of grey cast iron 1.8 to 2; ASME code of shafts, in the words of Engineers Edge: "
    "shear of 30 % of the yield point, but not over 18 % of the ultimate strength, 25 % less with "
    "a keyway; DIN 6885-1, as Siemens and Berger print "
    "it: depths of keyways.",
    checked="The page of 6.4.4 opened, and those of MITCalc and Engineers Edge: at 300 N/mm², a "
    "mild steel, 0.18 · 0.75 · 300 is 40.5 N/mm². The code itself was not. Of DIN 6885-1 its table "
    "as two catalogues print it (Siemens MD 31.1, 2016, bores above 38 mm; Berger's standard "
    "parts, bores up to 44 mm): every width and depth is the same. Nine tenths for "
    '"slightly less" is the quotient of MITCalc\'s ratios (0.89 to 0.9). A fifth and a tenth of '
    "the stroke are this program's, for want of a rule.",
    silenced_by="a shaft, a hub, or a base radius that is given or has a least value (all but a "
    "shaft too thin for the load, and a bore whose keyway has no wall)",
    find=_find,
)
