"""The texts of `--help`, one a command, with units and examples."""

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

Exit codes: 0 done; 1 the service cannot start; 2 the question is invalid, a file cannot be read
or written, or a service refuses it; 3 answered, with a negative result (no cam fits, a limit is
broken, a certificate is contradicted, items failed); 130 stopped by Ctrl-C.

Environment: CAMWRIGHT_URL is a service that design, analyse, cam-set, read-back, linkage and
sweep ask instead of computing here; CAMWRIGHT_TIME_BUDGET_S is the time in seconds that one
question may take here."""

DESIGN = """Size one cam: base radius, offset or pivot and motion laws together, and prove it.

Writes design.json (dimensions, motion, every limit with its extreme in its own unit, cam angle
and margin, the proven lower bound), profile.* and motion.* in the usual formats, lengths in mm,
angles in deg, and pictures. `camwright export` writes others. By a service the files are the same;
design.json then has the links under which the design is kept there as well.

\b
  camwright design spec.json --out results
  camwright design spec.json --out results --url http://127.0.0.1:8000

Exit codes: 0 a certified cam; 2 the question is invalid, or time ended without a cam; 3 no
cam fits: the limits that conflict are named, and design.json says what would help."""

CAM_SET = """Size the cams of one shaft, with their phases, and write all their files.

Writes cam-set.json, the timing diagram and a folder for each cam, its points in the cam's own
frame and, turned by its phase in deg, in the shaft's; lengths in mm.

\b
  camwright cam-set openapi/examples/cam-sets/feeder-and-press.json --out results

Exit codes: 0 every cam fits, or some do; 2 the question is invalid; 3 none fits."""

ANALYSE = """Analyse a given cam: its extremes, the limits that it breaks, and changes that help.

Prints every limit with its extreme and cam angle in deg, extremes and jumps of all curves in mm,
mm/s, mm/s², mm/s³ (deg on arms), undercut in mm, crossings, and the smallest base radius in mm
with which all limits hold.

\b
  camwright analyse openapi/examples/analyses/p2-as-given.json
  camwright analyse spec.json --json > analysis.json

Exit codes: 0 every limit holds; 2 the question is invalid or leaves something free; 3 a
limit is broken."""

SPATIAL = """Design one spatial cam, globoidal or cylindrical.

Prints its walls by roller and side, where in the turn (deg) each is met, and what was measured:
pressure angle in deg, undercut, radii and ribs in mm, speeds in mm/s and rpm, each with cam angle,
wall and place on the roller's axis in mm. --out writes the answer and its files.

\b
  camwright spatial openapi/examples/spatial-cams/p4.json
  camwright spatial cam.json --out results

Exit codes: 0 a cam that holds; 2 the question is invalid; 3 a wall is undercut, a rib cut
through or a limit broken: which and where is printed."""

CONFIRM = """Verify a finished design's certificate again, in ball arithmetic, to 25 digits.

The second verification shares neither formulas nor arithmetic with the first. It takes 0.05 to 2 s,
and the optional package `exact`: pip install 'camwright[exact]'.

\b
  camwright confirm results/design.json

Exit codes: 0 every line is confirmed; 2 the file is not a design, or the package is missing; 3 a
line is contradicted or not decided."""

COSTS = """Print what each limit of a design costs: the change of the objective for one unit more.

As in: 1 deg more in /limits/0/rise_deg makes base_radius 1.02 mm smaller. For large
numbers the change is 1 %. Derivatives come from multipliers, confirmed by solving again with the
number a thousandth larger and smaller; what is not confirmed is listed as such. Takes 0.1 to 5
s.

\b
  camwright costs results/design.json

Exit codes: 0 done; 2 the file is not a design; 3 no sensitivity is known, and why."""

READ_BACK = """Read the motion back from measured points of a profile.

Points are x y in mm, in the order of the profile, in the question or in a file of their own.
Prints the motion's extremes in mm and mm per s, the base radius in mm, the scatter in µm and
hollows that the follower does not reach.

\b
  camwright read-back cam.json --points measured.csv

Exit codes: 0 read; 2 a file cannot be read, or the points are of no cam."""

RESPOND = """Compute the response of an elastic follower train to a cam.

The question is a cam and a chain of masses in kg, springs in N/mm and dampers in N s/mm. Prints the
train's modes in Hz and, for every speed in rpm, the output's error in mm, the residual vibration
in the dwells in mm, and the contact force in N. With --out it writes the whole answer, a table,
diagrams and the residual spectrum.

\b
  camwright respond openapi/examples/train-responses/press-feeder.json --out results

Exit codes: 0 done; 2 the question is invalid, or no cam fits."""

LINKAGE = """Analyse or size a linkage: a six-bar shaper, or a palletising arm.

Writes linkage.json, tables, diagrams and animations; lengths in mm, angles in deg, velocities in
mm/s and deg/s, torques in N·m. A shaper's lengths left free are chosen for a stroke and a
quick-return ratio, with a proven bound.

\b
  camwright linkage six-bar-shapers openapi/examples/linkages/six-bar-shapers/p5.json --out results
  camwright linkage palletising-arms openapi/examples/linkages/palletising-arms/irb-660.json

Exit codes: 0 all requirements are met, all poses can be reached; 2 the question is invalid; 3 not
all, and what would help."""

SWEEP = """Run a sweep: many designs from one base spec, over any of its fields.

Writes sweep.json and the table items.csv (items.parquet with the package `parquet`), one row an
item, units in the names of the columns. Computed here, finished items are kept in the folder of
the results, and the same command continues a stopped sweep; a service keeps them itself.

\b
  camwright sweep openapi/examples/sweeps/rollers-and-laws.json --out results
  camwright sweep sweep.json --out results --url http://127.0.0.1:8000

Exit codes: 0 all items have an answer; 2 the question is invalid; 3 stopped, or items
failed; 130 Ctrl-C, with what is done kept."""

EXPORT = """Write files of one cam: of a design in a file, or of a question, computed now.

Lengths in mm, angles in deg, chord tolerances in µm. Each format has options of its own; an
unknown one is refused, with a list of those that there are.

\b
  camwright export results/design.json --format txt --points-per-degree 10
  camwright export results/design.json --format csv --curve pitch --tolerance-um 2
  camwright export results/design.json --part motion --format svg
  camwright export results/design.json --part picture --format contact.svg

Exit codes: 0 written; 2 no such format, option or curve, or no cam fits."""

SERVE = """Start the service with its page, its API and its documentation; no internet is needed.

Options left out come from the environment: CAMWRIGHT_HOST, CAMWRIGHT_PORT,
CAMWRIGHT_DATABASE_URL, CAMWRIGHT_SCHEDULER, and further CAMWRIGHT_WORKERS (processes),
CAMWRIGHT_TIME_BUDGET_S (seconds one question may take) and others, else from the defaults. It
designs a textbook cam as a self-check and prints its addresses; Ctrl-C stops it.

\b
  camwright serve
  camwright serve --host 0.0.0.0 --port 8080
  camwright serve --database-url postgresql+psycopg://user:secret@db/cams
  camwright serve --scheduler tcp://10.0.0.5:8786

Exit codes: 0 stopped by Ctrl-C; 1 the port, the database or a setting cannot be used, and why."""


def _unwrap(text: str) -> str:
    """Join the lines of paragraphs, for the terminal to wrap; examples keep theirs."""
    parts = text.split("\n\n")
    return "\n\n".join(p if p.startswith("\b") else p.replace("\n", " ") for p in parts)


ROOT = _unwrap(_ROOT)
HELP: Mapping[str, str] = {
    "design": _unwrap(DESIGN),
    "analyse": _unwrap(ANALYSE),
    "cam-set": _unwrap(CAM_SET),
    "sweep": _unwrap(SWEEP),
    "costs": _unwrap(COSTS),
    "spatial": _unwrap(SPATIAL),
    "confirm": _unwrap(CONFIRM),
    "export": _unwrap(EXPORT),
    "read-back": _unwrap(READ_BACK),
    "respond": _unwrap(RESPOND),
    "linkage": _unwrap(LINKAGE),
    "serve": _unwrap(SERVE),
}
