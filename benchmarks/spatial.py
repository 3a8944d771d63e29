"""Flanks of a globoidal cam: 200 × 200 points with normals; whole answers, given and sized."""

import json

import numpy as np

from benchmarks.effort import FULL, Effort
from benchmarks.section import Section, Table
from benchmarks.timing import Call, in_turns
from service.contract.examples import examples
from synthesis.exporters import FileContent
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.step import BODY, FacetedOptions
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec

POINTS = 200
SOLIDS = (
    "cylindrical-groove", "cylindrical-rib", "cylindrical-sized", "cylindrical-indexer", "p4",
    "globoidal-sized",
)  # fmt: skip
TEXT = (
    "The published indexing cam P4: its flank 2R as a grid of cam angle by depth. The error is "
    "against the literature's meshing formula in the processor's longest numbers. The last row is "
    "the example globoidal-sized. Below it the examples' body.step, as it comes unasked."
)
Longest = np.longdouble


def given(name: str = "p4") -> SpatialCamSpec:
    """An example; P4 is given in full."""
    return SpatialCamSpec.model_validate_json(json.dumps(examples("spatial-cams")[name]["value"]))


def textbook(count: int) -> np.ndarray:
    """Points (3, count, count) of flank 2R over the index, by tan η = ρψ'/(C − ρ cos ψ)."""
    pi = Longest("3.14159265358979323846264338327950288")
    x = np.arange(count, dtype=Longest)[:, None] / (count - 1)
    y = np.minimum(x, 1 - x)
    near = y < Longest(0.25)
    pulse = 2 * (y - np.sin(4 * pi * y) / (4 * pi)) / 3
    run = Longest(1) / 6 + 4 * (y - Longest(0.25)) / 3
    s = np.where(near, pulse, run)
    s = np.where(x < 0.5, s, 1 - s)
    v = np.where(near, 2 * (1 - np.cos(4 * pi * y)) / 3, 4 / Longest(3))
    theta, psi, ratio = 2 * pi / 3 * x, pi / 3 * s - pi / 6, v / 2
    rho = 72 + 30 * np.arange(count, dtype=Longest) / (count - 1)
    eta = np.arctan(rho * ratio / (180 - rho * np.cos(psi)))
    a = rho * np.cos(psi) - 30 * np.cos(eta) * np.sin(psi) - 180
    b = rho * np.sin(psi) + 30 * np.cos(eta) * np.cos(psi)
    c = 30 * np.sin(eta)
    return np.stack([np.cos(theta) * a - np.sin(theta) * c, b,
                     np.sin(theta) * a + np.cos(theta) * c])  # fmt: skip


def run(effort: Effort = FULL) -> Section:
    """Time and error."""
    spec, free = given(), given("globoidal-sized")
    cam = synthesise_spatial(spec).cam
    wall = next(wall for wall in cam.walls if wall.name == "2R")
    theta, rho = np.linspace(0.0, 2.0 * np.pi / 3.0, POINTS), np.linspace(72.0, 102.0, POINTS)
    answers: list[SpatialDesign] = []
    calls: dict[str, Call] = {
        f"{POINTS} × {POINTS} points and normals": lambda: cam.surface(wall, theta, rho),
        "their pressure angles and undercut": lambda: cam.contacts(wall, theta, rho),
        "their principal curvatures": lambda: cam.swept.curvatures(
            cam.place(wall.seat, theta), rho, wall.side
        ),
        "the whole answer, all measured": lambda: synthesise_spatial(spec),
        "law and centre distance chosen, with bound and all measured": lambda: answers.append(
            synthesise_spatial(free)
        ),
    }
    times = in_turns(calls, effort.repeats(40), effort.warm_up(3))
    away = np.sqrt(((cam.surface(wall, theta, rho)[0] - textbook(POINTS)) ** 2).sum(axis=0)).max()
    error = f"{float(away):.0e} mm"
    first, *_ = times.values()
    rows = [(name, str(time), error if time is first else "") for name, time in times.items()]
    table = Table(("what", ">time", ">error"), rows)
    reported = f"{POINTS} × {POINTS} points of a globoidal cam's flank, with normals"
    front = (reported, str(first), error)
    *_, whole = times.values()
    gap = answers[0].certificate.gap or 0.0
    sized = ("a sized globoidal cam: the whole answer", str(whole), f"gap {100.0 * gap:.2f} %")
    return Section("Flanks of a globoidal cam", TEXT, [table, _solids(effort)], [front, sized])


def _solids(effort: Effort) -> Table:
    """Time and error of solids as files."""
    names, question = effort.some(SOLIDS), FacetedOptions()
    designs = {name: synthesise_spatial(given(name)) for name in names}
    made: dict[str, FileContent] = {}
    calls: dict[str, Call] = {
        name: lambda name=name, design=design: made.update({name: BODY.content(design, question)})
        for name, design in designs.items()
    }
    times, rows = in_turns(calls, effort.repeats(2), effort.warm_up(0)), []
    for name in names:
        data, facts = made[name].data, made[name].metadata
        size, error = len(data) / 1e6, 1e3 * float(facts["Surface-Error-Mm"])
        reported = (facts["Body"], facts["Faces"], f"{error:.2f} µm", f"{size:.2f} MB")
        rows.append((name, *reported, str(times[name])))
    return Table(("body.step", "body", ">faces", ">walls within", ">size", ">time"), rows)
