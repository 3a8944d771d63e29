"""Whether cam and follower bear the contact: its Hertz pressure, and the line it is computed on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from synthesis.pipeline.advice.rule import Finding, Rule, number
from synthesis.pipeline.advice.subject import Subject

FATIGUED: Final = 1500.0  # MPa: fatigue limit of rolling bearings, the hardest steel in use
DENTED: Final = 4000.0  # MPa: static rating of roller bearings
HARDEST: Final = 250e3  # MPa, elastic modulus: above it are carbides and ceramics, not steels


def _find(subject: Subject) -> Iterator[Finding]:
    load, forces, body = subject.spec.load, subject.design.forces, subject.spec.body
    contact = None if load is None else load.contact
    if contact is None:
        return
    if body is not None and contact.width_mm > body.thickness_mm:
        yield Finding(
            "caution", "load/contact/width_mm",
            f"The contact is {number(contact.width_mm)} mm wide, the cam "
            f"{number(body.thickness_mm)} mm thick: the Hertz pressure is that of a line which "
            "the cam does not have.",
            "Give the width on which cam and follower touch, or a thicker cam "
            "(body/thickness_mm).",
        )  # fmt: skip
    weaker = min(contact.cam.elastic_modulus_mpa, contact.follower.elastic_modulus_mpa)
    if forces is None or subject.limited("hertz_pressure") or weaker > HARDEST:
        return
    peaks = [each.largest_pressure_mpa for each in forces.flanks]
    peak = max((each for each in peaks if each), key=lambda each: each.value, default=None)
    if peak is not None and peak.value > FATIGUED:
        dented = peak.value > DENTED
        limit, suffer = (
            (DENTED, "even rolling bearings are dented by a load at rest")
            if dented
            else (FATIGUED, "even the steel of rolling bearings bears a limited number of turns")
        )
        yield Finding(
            "stop" if dented else "note", "load/contact",
            f"The Hertz pressure comes to {number(peak.value)} MPa at {number(peak.angle_deg)}°: "
            f"above {number(limit)} MPa {suffer}.",
            "Limit it (limit hertz_pressure, max_mpa), take a wider cam and roller, or lower the "
            "load.",
        )  # fmt: skip


RULE = Rule(
    code="contact_pressure",
    thresholds="stop: the Hertz pressure above 4000 MPa where cam or follower is no harder than "
    "steel (elastic modulus up to 250 000 MPa), note: above 1500 MPa; caution: "
    "`load/contact/width_mm` above `body/thickness_mm`.",
    reason="At 4000 MPa roller and raceway of a bearing keep a dent of 0.0001 of the roller's "
    "diameter; above 1500 MPa their life is finite, however clean they run. A cam bears less, as "
    "steel, hardness and lubrication allow: give it as a limit.",
    source="ISO 76, as NSK prints it: the static load rating of roller bearings is that of "
    "4000 MPa. ISO 281:2007, as Zaretsky reports it: a fatigue limit of 1500 MPa. The width is "
    "geometry.",
    checked="NSK's page opened, and a second one that quotes ISO 76:2006, 3.2 and 3.3; Zaretsky's "
    "article, who doubts that there is such a limit. Of cams: the Cam Design Handbook (Rothbart, "
    "ed., 2004), section 9.1, opened, says that reliable data are lacking; ISO 6336-5, which "
    "others take for cams, could not be opened.",
    silenced_by="the limit hertz_pressure (the pressure)",
    find=_find,
)
