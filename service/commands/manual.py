"""The manual of the command: what `--help` says, one text a command, with units and examples."""

from __future__ import annotations

from collections.abc import Mapping

_ROOT = """Cam design by optimisation, with proofs: as a service, or one question at a time.

A question is a JSON file in the form of the service's request bodies; GET /docs and the files of
openapi/examples show it. Units are in the names of its fields: mm, deg, rpm, s, and in results
mm/s, mm/s², mm/s³, deg/s and so on for followers on arms.

\b
Begin with
  camwright design openapi/examples/example-13-6-sized.json --out results
  camwright costs results/design.json
  camwright serve

Exit codes: 0 done; 1 the service cannot start; 2 the question makes no sense, a file cannot be
read or written, or a service says no; 3 answered, and the answer is no (no cam fits, a limit is
broken, a certificate is contradicted, items failed); 130 stopped by Ctrl-C.

Environment: CAMWRIGHT_URL is a service that design, analyse, cam-set, read-back, linkage and
sweep ask instead of working here; CAMWRIGHT_TIME_BUDGET_S is the time in seconds that one question
may take here."""

DESIGN = """Size one cam: base radius, offset or pivot and motion laws together, and prove it.

Writes design.json (dimensions, motion, every limit with its extreme in its own unit, cam angle
and margin, the proven lower bound), profile.* and motion.* in the usual formats, lengths in mm,
angles in deg, and pictures. `camwright export` writes others. By a service the files are the same;
design.json then has the links under which the design is kept there as well.

\b
  camwright design spec.json --out results
  camwright design spec.json --out results --url http://127.0.0.1:8000

Exit codes: 0 a certified cam; 2 the question makes no sense, or time ended without a cam; 3 no
cam fits: the limits that conflict are named, and design.json says what would help."""

CAM_SET = """Size the cams of one shaft, with their phases, and write all their files.

Writes cam-set.json, the timing diagram and a folder for each cam, its points in the cam's own
frame and, turned by its phase in deg, in the shaft's; lengths in mm.

\b
  camwright cam-set openapi/examples/cam-sets/feeder-and-press.json --out results

Exit codes: 0 every cam fits, or some do; 2 the question makes no sense; 3 none fits."""

ANALYSE = """Analyse a cam that is given in full: what it does, what it breaks, and what mends
it.

Prints every limit with its extreme and cam angle in deg, extremes and jumps of all curves in mm,
mm/s, mm/s², mm/s³ (deg on arms), undercut in mm, crossings, and the smallest base radius in mm
that mends it.

\b
  camwright analyse openapi/examples/analyses/p2-as-given.json
  camwright analyse spec.json --json > analysis.json

Exit codes: 0 every limit holds; 2 the question makes no sense or leaves something free; 3 a
limit is broken."""

SPATIAL = """Design one spatial cam, globoidal or cylindrical: its rollers stand across the cam.

Prints its walls by roller and side, where in the turn (deg) each is met, and what was measured:
pressure angle in deg, undercut, radii and ribs in mm, speeds in mm/s and rpm, each with cam angle,
wall and place on the roller's axis in mm. --out writes the answer and its files.

\b
  camwright spatial openapi/examples/spatial-cams/p4.json
  camwright spatial cam.json --out results

Exit codes: 0 a cam that holds; 2 the question makes no sense; 3 a wall is undercut, a rib cut
through or a limit broken: which and where is told."""

CONFIRM = """Measure a finished design's certificate again, in ball arithmetic, to 25 digits.

A second judge that shares neither formulas nor arithmetic with the first. Takes 0.05 to 2 s, and
the optional part `exact`: pip install 'camwright[exact]'.

\b
  camwright confirm results/design.json

Exit codes: 0 every line is confirmed; 2 the file is no design, or the part is missing; 3 a line
is contradicted or stays open."""

COSTS = """Say what each limit of a design costs: what one unit more of it would change.

As in: 1 deg more in /limits/0/rise_deg makes base_radius 1.02 mm smaller. Large numbers are told
for 1 % more. Slopes come from multipliers, confirmed by seeking the optimum again with the
number a thousandth larger and smaller; what is not confirmed is listed as such. Takes 0.1 to 5
s.

\b
  camwright costs results/design.json

Exit codes: 0 told; 2 the file is no design; 3 nothing is known, and why."""

READ_BACK = """Read the motion back from measured points of a profile.

Points are x y in mm, in the order of the profile, in the question or in a file of their own.
Prints the motion's extremes in mm and mm per s, the base radius in mm, the scatter in µm and
hollows that the follower does not reach.

\b
  camwright read-back cam.json --points measured.csv

Exit codes: 0 read; 2 a file cannot be read, or the points are of no cam."""

RESPOND = """Say what an elastic follower train does on a cam: vibration, contact force, its loss.

The question is a cam and a chain of masses in kg, springs in N/mm and dampers in N s/mm. Prints the
train's modes in Hz and, for every speed in rpm, the output's error in mm, what swings on in the
dwells in mm, and the contact force in N. With --out it writes the whole answer, a table, diagrams
and the residual spectrum.

\b
  camwright respond openapi/examples/train-responses/press-feeder.json --out results

Exit codes: 0 told; 2 the question makes no sense, or no cam fits."""

LINKAGE = """Analyse or size a linkage: a six-bar shaper, or a palletising arm.

Writes linkage.json, tables, diagrams and animations; lengths in mm, angles in deg, velocities in
mm/s and deg/s, torques in N·m. A shaper's lengths left free are chosen for a stroke and a
quick-return ratio, with a proven bound.

\b
  camwright linkage six-bar-shapers openapi/examples/linkages/six-bar-shapers/p5.json --out results
  camwright linkage palletising-arms openapi/examples/linkages/palletising-arms/irb-660.json

Exit codes: 0 every wish is kept, every pose can be taken; 2 the question makes no sense; 3 not
all of them, and what would help."""

SWEEP = """Run a sweep: many designs out of one, over any fields of its question.

Writes sweep.json and the table items.csv (items.parquet with the part `parquet`), one row an
item, units in the names of the columns. Here its progress is kept in the folder of the results;
stopped or killed, the same command goes on where it was. By a service it is kept there.

\b
  camwright sweep openapi/examples/sweeps/rollers-and-laws.json --out results
  camwright sweep sweep.json --out results --url http://127.0.0.1:8000

Exit codes: 0 all items have an answer; 2 the question makes no sense; 3 stopped, or items
failed; 130 Ctrl-C, with what is done kept."""

EXPORT = """Write files of one cam: of a design that was kept, or of a question, sized now.

Lengths in mm, angles in deg, chord tolerances in µm. Each format has options of its own; one
that it does not have is refused with those that it has.

\b
  camwright export results/design.json --format txt --points-per-degree 10
  camwright export results/design.json --format csv --curve pitch --tolerance-um 2
  camwright export results/design.json --part motion --format svg
  camwright export results/design.json --part picture --format contact.svg

Exit codes: 0 written; 2 no such format, option or curve, or no cam fits."""

SERVE = """Start the service with its page, its API and its documentation; no internet is needed.

What is left out comes from the environment: CAMWRIGHT_HOST, CAMWRIGHT_PORT,
CAMWRIGHT_DATABASE_URL, CAMWRIGHT_SCHEDULER, and further CAMWRIGHT_WORKERS (processes),
CAMWRIGHT_TIME_BUDGET_S (seconds one question may take) and others, else from the defaults. It
sizes a textbook cam as a self-check, prints its addresses, and ends in order with Ctrl-C.

\b
  camwright serve
  camwright serve --host 0.0.0.0 --port 8080
  camwright serve --database-url postgresql+psycopg://user:secret@db/cams
  camwright serve --scheduler tcp://10.0.0.5:8786

Exit codes: 0 stopped in order; 1 the port, the database or a setting cannot be used, and why."""


def _flowing(text: str) -> str:
    """Paragraphs as one line each, for the terminal to break; examples as they stand."""
    parts = text.split("\n\n")
    return "\n\n".join(p if p.startswith("\b") else p.replace("\n", " ") for p in parts)


ROOT = _flowing(_ROOT)
HELP: Mapping[str, str] = {
    "design": _flowing(DESIGN),
    "analyse": _flowing(ANALYSE),
    "cam-set": _flowing(CAM_SET),
    "sweep": _flowing(SWEEP),
    "costs": _flowing(COSTS),
    "spatial": _flowing(SPATIAL),
    "confirm": _flowing(CONFIRM),
    "export": _flowing(EXPORT),
    "read-back": _flowing(READ_BACK),
    "respond": _flowing(RESPOND),
    "linkage": _flowing(LINKAGE),
    "serve": _flowing(SERVE),
}
