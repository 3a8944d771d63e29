#!/usr/bin/env python3
"""Check proofs about cams, in exact arithmetic: python3 -I -S check.py proof.json | proofs.zip

One file, the standard library alone, integers and fractions in everything that it concludes. It
reads the question as it was asked and believes nothing else in the file: the cam and the
multipliers are witnesses, which may be wrong and are then refused. docs/proof.md has the format,
the symbols, and the theorem behind each step by its number here. Exit codes: 0 and a sentence for
each claim; 1 and the first step that fails; 2 and why the file cannot be read. Of several files, in
an archive or named one after the other, the largest code.

Angles are in degrees: on a segment of d degrees s = level + h g(x), and v, a, j are the derivatives
of s per degree [mm]. A degree is c = pi/180 radian: s' = v/c, s'' = a/c^2. Of a roller X = s0 + s,
u = s' - e, W^2 = X^2 + u^2. The size z is (c e, s0), of a flat face (c^2 Rb, 0).
"""
import json
import re
import sys
from bisect import bisect
from collections import Counter, defaultdict
from copy import copy, deepcopy
from fractions import Fraction
from functools import lru_cache
from itertools import product, zip_longest
from math import comb, factorial, isqrt
from zipfile import ZipFile

MOST_BYTES, MOST_DIGITS, MOST_EXPONENT = 5_000_000, 25, 60  # of the file; of a number
MOST_SEGMENTS, MOST_LIMITS, MOST_FILES = 100, 50, 1000  # of a question; of an archive;
# of a file, all claims together:
MOST = {"numbers": 200_000, "halvings of intervals": 500_000, "coefficients": 1_000_000}
SLICES, FINE = 8, 1 << 70  # of a density of rows that differ from place to place; what is rounded
DEEPEST, BITS = 60, 120  # halvings of one piece; enclosures are rounded outwards to 1/UNIT
UNIT, ZERO, ONE = 1 << BITS, Fraction(0), Fraction(1)
TERMS, SHARP = 10, UNIT >> 44  # of series, and powers of polynomials along arms; how well known
JUMP = Fraction(1, 10**7)  # of a derivative's scale: what it may jump by at a joint; it is told
ROUNDING = Fraction(1, 10**6)  # of (degrees/width)^k, as 3rd and 4th derivatives of narrow pieces
GAP = Fraction(1, 10**9)  # of the stroke: what a sum of lifts that closes may miss
TYPED = Fraction(1, 10**12)  # of an angle: what the end of a window may lie beyond it
GRAVITY, MILLI = Fraction(980665, 10**5), Fraction(1, 1000)  # m/s^2; m in a mm
AIMS = ("base_radius", "peak_acceleration", "peak_jerk", "peak_pressure_angle",
        "rms_acceleration", "rms_jerk")
FIELDS = {  # of each kind that is covered; what has another field is refused
    "question": "name? speed_rpm rotation? program follower base_radius_mm load? limits "
                "continuity objective tolerance? proof? time_budget_s? report_smoothness_cost? "
                "body? keyway?",
    "dwell": "angle_deg", "constant_velocity": "angle_deg lift_mm? velocity_mm_per_s?",
    "chosen": "angle_deg? lift_mm?",  # of a segment of the cam
    "rise": "angle_deg lift_mm law windows? points?", "spline": "smoothness overshoot",
    "return": "angle_deg lift_mm law windows? points?", "force": "contact rim_mm?",
    "groove": "clearance_mm rim_mm",
    "conjugate": "roller_radius_mm offset_mm? distance_mm? arm_mm? angle_deg?",
    "windows": "from_deg to_deg travel_mm? velocity_mm_per_s? acceleration_mm_per_s2? "
               "jerk_mm_per_s3?",
    "points": "angle_deg travel_mm? tolerance_mm? tolerance_deg? velocity_mm_per_s?",
    "named law": "inflection",
    "translating_roller": "roller_radius_mm closure? offset_mm",
    "translating_flat_face": "offset_mm tilt_deg",
    "oscillating_roller": "roller_radius_mm closure? arm_mm centre_distance_mm sense "
                          "pivot_direction_deg",
    "velocity": "max_mm_per_s", "acceleration": "max_mm_per_s2", "jerk": "max_mm_per_s3",
    "pressure_angle": "rise_deg return_deg dwell_deg", "cutter_radius": "radius_mm",
    "profile_radius": "min_mm", "outer_radius": "max_mm", "counter_base_radius": "min_mm",
    "oscillating_flat_face": "centre_distance_mm face_offset_mm sense pivot_direction_deg",
    "face_width": "width_mm? left_mm? right_mm? near_mm? far_mm?",
    "contact_force": "max_n min_n", "hertz_pressure": "max_mpa", "camshaft_torque": "max_n_m",
    "slide": "moving_mass_kg damping_n_s_per_m spring process rise_from_vertical_deg speeds? "
             "contact? bearing?",
    "arm": "moment_of_inertia_kg_m2 damping_n_m_s_per_rad spring process speeds? contact? "
           "bearing?",
    "slide spring": "rate_n_per_mm preload_n solid_mm?",
    "arm spring": "rate_n_m_per_rad preload_n_m",
    "slide process": "angle_deg force_n", "arm process": "angle_deg moment_n_m",
    "line contact": "width_mm cam follower", "material": "elastic_modulus_mpa poisson_ratio",
    **dict.fromkeys(AIMS, "allowance?")}  # which the claims state as a value
POLYNOMIALS = {  # g by its lowest power and the coefficients from there on
    "cubic_2_3": (2, 3, -2), "polynomial_3_4_5": (3, 10, -15, 6),
    "polynomial_4_5_6_7": (4, 35, -84, 70, -20),
    "polynomial_5_6_7_8_9": (5, 126, -420, 540, -315, 70),
    "polynomial_6_7_8_9_10_11": (6, 462, -1980, 3465, -3080, 1386, -252),
    "peisakh_11": (5, 336, -1890, 4740, -6615, 5320, -2310, 420)}
SCCA = {  # 40ths of b, c and d: sine, constant and cosine parts of the acceleration
    "parabolic": (0, 40, 0), "simple_harmonic": (0, 0, 40), "cycloidal": (20, 0, 20),
    "modified_trapezoid": (10, 20, 10), "modified_sine": (10, 0, 30), "mcv50_makino": (5, 0, 15),
    "cv50_half_sine": (10, 0, 10), "cv50_modified_trapezoid": (5, 10, 5), "scca_cv20": (8, 16, 8)}
FOLLOWERS = ("translating_roller", "translating_flat_face", "oscillating_roller",
             "oscillating_flat_face")
ORDERS = {"velocity": 1, "acceleration": 2, "jerk": 3}
FORCES = ("contact_force", "hertz_pressure", "camshaft_torque")
MEET = {**{kind: order - 1 for kind, order in ORDERS.items()},  # derivatives that may not jump
        "pressure_angle": 0, "face_width": 0, "profile_radius": 1, "cutter_radius": 1,
        "outer_radius": 0, "counter_base_radius": 0, "rms_acceleration": 1, "rms_jerk": 2,
        **dict.fromkeys(FORCES, 1)}
UNKNOWN = {"kind": "unknown"}  # a limit of which nothing is said
SQUARES = {"rms_acceleration": 2, "rms_jerk": 3}
TWINS = {name.format(one): name.format(other) for one, other in (("mm", "deg"), ("deg", "mm"))
         for name in ("lift_{}", "velocity_{}_per_s", "acceleration_{}_per_s2", "jerk_{}_per_s3",
                      "travel_{}", "tolerance_{}", "max_{}_per_s", "max_{}_per_s2",
                      "max_{}_per_s3")}
spent = Counter()

class Failure(Exception):
    """Why a file is refused; with a second argument, why it cannot be read."""

def demand(holds, text, *code):
    if not holds:
        raise Failure(text, *code)

def spend(what, count=1):
    spent[what] += count
    demand(spent[what] <= MOST[what], f"there are more than {MOST[what]} {what}", 2)

# Step 1. Read. Decimals become fractions; digits and exponents are bounded before that.
def number(text):
    spend("numbers")
    form = r"(-?[0-9]+)(?:\.([0-9]+))?(?:[eE]([+-]?[0-9]+))?"
    match = re.fullmatch(form, text) if len(text) <= MOST_DIGITS else None
    good = match and abs(int(match[3] or 0)) <= MOST_EXPONENT
    demand(good, f"{text[:50]} is no number, or has too many digits", 2)
    digits = match[2] or ""
    return int(match[1] + digits) * Fraction(10) ** (int(match[3] or 0) - len(digits))

def once(pairs):
    demand(len(dict(pairs)) == len(pairs), "a name occurs twice in one object", 2)
    return dict(pairs)

def read(content):
    demand(len(content) <= MOST_BYTES, f"the file has more than {MOST_BYTES} bytes", 2)
    return json.loads(content.decode(), parse_float=number, parse_int=number,
                      parse_constant=number, object_pairs_hook=once)

def get(body, name, kind=Fraction):
    good = isinstance(body, dict) and isinstance(body.get(name), kind)
    demand(good, f"{name} is missing, or not of the kind that it must have", 2)
    return body[name]

def numbers(values):
    good = all(isinstance(x, Fraction) for x in values)
    demand(good, "what is no number stands where one must be", 2)
    return values

def whole(body, name, least, most):
    value = get(body, name)
    demand(value in range(least, most + 1), f"{name} is none of {least} to {most}", 2)
    return int(value)

def fields(kind):
    """The names that an object of a kind may have, and whether it must have them."""
    return {name.rstrip("?"): name[-1] != "?" for name in FIELDS[kind].split()}

def kind_of(body, *kinds):
    """What an object is, one of some kinds, without anything that this checker does not know.

    Where there is one kind alone its name may be left out.
    """
    kind = get(body, "kind", str) if kinds[1:] or "kind" in body else kinds[0]
    demand(kind in kinds, f"{ascii(kind)[:40]} is not covered")
    names = fields("named law" if kind in (*POLYNOMIALS, *SCCA) else kind)
    unknown = [k for k, v in body.items() if k not in ("kind", *names) and v not in (None, [], {})]
    demand(not unknown, f"{kind} has {ascii(unknown)[:80]}, which is not covered")
    missing = [k for k, needed in names.items() if needed and k not in body]
    demand(not missing, f"{kind} has no {', '.join(missing)}", 2)
    return kind

def range_of(value):
    """Both ends of a number that is given, free within a range, or free; None where open."""
    found = value if isinstance(value, dict) else {"min": value, "max": value}
    demand(len(found) == 2, "a range has other ends than min and max")
    return [None if found[end] is None else get(found, end) for end in ("min", "max")]

def choose(asked, chosen):
    """A number as it is given, or that of the cam if the question leaves a range."""
    if not isinstance(asked, dict):
        demand(chosen in (None, asked), "a number of the cam is not that asked for")
        return asked
    demand(chosen is not None, "a number is free: over all of its values nothing is covered")
    good = isinstance(chosen, Fraction) and all(end is None or way * chosen <= way * end
                                                for way, end in zip((-1, 1), range_of(asked)))
    demand(good, "a number is not within the range asked for")
    return chosen

# Step 2. The question. Levels are measured from the lowest position.
def turned(body):
    """What is said of an arm in degrees, in the place of what is said of others in mm."""
    return {TWINS.get(name, name): [turned(each) for each in value] if name in (
        "windows", "points") and value else value for name, value in body.items()}

class Segment:
    def __init__(self, index, body, rate, chosen):
        kind = kind_of(body, "rise", "return", "dwell", "constant_velocity")
        kind_of(chosen, "chosen")
        body = {**body, **{name: choose(body.get(name), chosen.get(name))
                           for name in ("angle_deg", "lift_mm")}}
        self.index, self.free, self.degrees, self.law = index, False, body["angle_deg"], "line"
        self.body = body
        self.rate = rate
        self.lift, self.smooth, self.forward, good = ZERO, 4, False, get(body, "angle_deg") > 0
        if kind in ("rise", "return"):
            law, lift = body["law"], get(body, "lift_mm")
            self.law = kind_of(law, "spline", *POLYNOMIALS, *SCCA)
            self.free = self.law == "spline"
            if self.free:
                self.forward = not get(law, "overshoot", bool)
                self.smooth = whole(law, "smoothness", 1, 4)
            else:
                demand(get(law, "inflection") * 2 == 1, "a moved inflection is not covered")
            self.lift = lift if kind == "rise" else -lift
            good = good and lift > 0
        elif kind == "constant_velocity":
            (name,) = (k for k in ("lift_mm", "velocity_mm_per_s") if body.get(k) is not None)
            self.lift = get(body, name) * (1 if name == "lift_mm" else self.degrees / rate)
        demand(good or (kind == "dwell" and self.degrees == 0), f"program/{index} is not valid")
        self.sense = "rise" if self.lift > 0 else "return" if self.lift < 0 else "dwell"

    def square(self, order):
        """The integral of (s^(order))^2 per degree over that of (g^(order))^2."""
        return self.lift**2 / self.degrees ** (2 * order - 1)

    def given(self, k, x):
        """A derivative of s per degree under a given law, of s without the level: its bounds."""
        scale = self.lift / self.degrees**k
        return sorted(scale * bound for bound in given(self.law, k, x))

    def speed(self, end):
        """The velocity at its start (end 0) or its end (1), where what it meets there tells."""
        beside = self.after if end else self.before
        turns = self.forward and beside.forward and self.lift * beside.lift < 0
        demand(turns or not beside.free, "the velocity there is not known")
        return [ZERO, ZERO] if turns else beside.given(1, ONE - end)

    def depth(self, jerk):
        """How far below 0 it may go; None where nothing is known of that.

        By Taylor's formula from a neighbour that is given: derivatives below a limited one meet.
        """
        if self.forward or not self.free:
            return ZERO
        if jerk is None or (self.before.free and self.after.free):
            return None
        near, end = (self.after, ZERO) if self.before.free else (self.before, ONE)
        v, a = (max(map(abs, near.given(k, end))) for k in (1, 2))
        return v * self.degrees + a * self.degrees**2 / 2 + jerk * self.degrees**3 / 6

    def bounds(self):
        """What windows and points ask of s^(k) from one x to another, as limits by their names.

        And the scale of s^(k) where it is one value, which a decimal may miss; else 0.
        """
        asked = ((name, *each) for name in ("windows", "points")
                 for each in enumerate(self.body.get(name) or ()))
        for name, number, each in asked:
            spend("coefficients", 8)
            kind_of(each, name)
            ends = ["angle_deg"] * 2 if name == "points" else ["from_deg", "to_deg"]
            first, last = (get(each, end) / self.body["angle_deg"] for end in ends)
            demand(0 <= first <= last <= 1 + TYPED, f"{name} beyond the segment")
            demand(not each.get("tolerance_deg"), "a tolerance in another unit")
            found = [range_of(each.get(field)) for field in [*fields("windows")][2:]]
            demand(found != [[None, None]] * 4, f"{name} that bound nothing")
            for k, asked in enumerate(found):
                slack = ZERO if k or each.get("tolerance_mm") is None else get(each, "tolerance_mm")
                demand(slack >= 0, "a tolerance is negative")
                exact = asked[0] == asked[1] is not None and slack == 0
                way = -1 if k == 0 and self.lift < 0 else 1  # of travel, in the sense of the move
                asked = [end if end is None else way * (end / self.rate**k + side * slack)
                         + (0 if k else self.level) for end, side in zip(asked, (-1, 1))][::way]
                if asked != [None, None]:
                    yield f"program/{self.index}/{name}/{number}/{k}", {
                        "kind": "within", "of": self, "order": k, "ends": asked,
                        "from": min(first, ONE), "to": min(last, ONE),
                        "scale": abs(self.lift) / self.degrees**k if exact else ZERO}

class Question:
    def __init__(self, body, chosen=()):
        kind_of(body, "question")
        rate = self.rate = 6 * get(body, "speed_rpm")  # degrees per second
        demand(rate > 0, "the speed is not positive")
        follower = self.follower = get(body, "follower", dict)
        kind = kind_of(follower, *FOLLOWERS)
        self.face, self.swung = kind[-4:] == "face", kind[:11] == "oscillating"
        self.arm = self.swung and not self.face
        program, limits, chosen = (
            [turned(each) for each in found] if self.swung else found
            for found in (get(body, "program", list), get(body, "limits", list), chosen))
        good = len(program) <= MOST_SEGMENTS and len(limits) <= MOST_LIMITS
        demand(good, "there are too many segments or limits", 2)
        demand(len(chosen) in (0, len(program)), "the cam has not as many segments", 2)
        self.program = [Segment(i, s, rate, chosen[i] if chosen else {})
                        for i, s in enumerate(program)]
        self.load, self.loaded = body.get("load"), None
        turn, level, levels, at = sum(s.degrees for s in self.program), ZERO, [], ZERO
        demand(abs(turn - 360) <= Fraction(1, 10**6), "the angles do not sum to 360")
        self.smooth = 0 if body["continuity"] is None else whole(body, "continuity", 0, 4)
        for segment in self.program:  # angles typed with six decimals may miss the turn
            segment.degrees *= 360 / turn
            segment.begin, at = at, at + segment.degrees
            segment.smooth = max(segment.smooth, self.smooth)
            levels.append(level)
            level += segment.lift
        demand(abs(level) <= GAP * (max(levels) - min(levels)), "the lifts do not sum to 0")
        for segment, start in zip(self.program, levels):
            segment.level = start - min(levels)
        self.turning = [s for s in self.program if s.degrees > 0]
        for left, right in zip(self.turning, self.turning[1:] + self.turning[:1]):
            left.after, right.before = right, left
        held = follower.get("closure") or {"kind": "force", "contact": "outside"}
        kind, contact = kind_of(held, "force", "groove", "conjugate"), held.get("contact")
        demand(contact in (("outside", "inside") if kind == "force" else (None,)),
               "this contact is not covered")
        slack = get(held, "clearance_mm") if kind == "groove" else ZERO
        rim = get(held, "rim_mm") if kind == "groove" or contact == "inside" else ZERO
        gap = (ZERO if self.face else get(follower, "roller_radius_mm")) + slack / 2
        # of each flank: the side on which its roller lies, how far its curve is from the roller's
        # path, the rim around it, and which path, the main roller's or the counter roller's
        sides = (1, -1) if kind == "groove" else (-1,) if contact == "inside" else (1,)
        self.flanks = [(side, gap, rim if side < 0 else ZERO, 0) for side in sides]
        self.conjugate, self.gap = kind == "conjugate", sides[0] * gap
        self.held, self.offsets = held, [None, None]
        if self.conjugate:
            self.flanks.append((1, get(held, "roller_radius_mm"), ZERO, 1))
            unknown = "distance_mm offset_mm" if self.arm else "arm_mm angle_deg"
            demand(not any(held.get(name) for name in unknown.split()), "it is not covered")
        good = min(slack, rim, *(distance for _, distance, *_ in self.flanks)) >= 0
        demand(good, "this follower is not covered")
        self.tilt, self.offset, self.away = ZERO, ZERO, ZERO  # of a face; its distance from a pivot
        if self.swung:
            demand(get(follower, "sense", str) in ("opposite", "same"), "no sense of an arm")
            self.sense = (1, -1)[follower["sense"] == "same"]
            self.away = get(follower, "face_offset_mm") if self.face else ZERO
        elif self.face:
            self.tilt, self.offset = get(follower, "tilt_deg"), get(follower, "offset_mm")
            demand(abs(self.tilt) < 90, "it is no face")
        cosines = circle(self.tilt)[1] if self.tilt else (ONE, ONE)
        self.cosine, self.lean = enclosed(cosines), enclosed(1 / x for x in cosines[::-1])
        if not self.swung:  # a face as a roller of radius 0 without an offset, s0 the base radius
            self.offsets = [ZERO, ZERO] if self.face else range_of(follower["offset_mm"])
        # of an arm lengths count in its own length, so that e and s0 are angles nearly
        self.unit, self.arms, self.wide, self.top = C, [ONE, ONE], ZERO, None
        if self.swung:
            self.unit, self.distances = (ONE, ONE), range_of(follower["centre_distance_mm"])
        if self.arm:
            self.arms = range_of(follower["arm_mm"])
        elif self.swung and self.distances[1] is None:
            self.arms = [None, None]  # nothing limits the size
        elif self.swung:  # in mm: p = 1 + sense e is positive, and so is the base radius, s0
            self.offsets = sorted(self.sense * (p - 1) for p in (ZERO, self.distances[1]))
            # no e is farther from 0, no base radius larger
            self.wide, self.top = self.distances[1] + 1, max(self.distances[1] - self.away, ZERO)
        self.radii = [r if r is None else self.prime(r) for r in range_of(body["base_radius_mm"])]
        others = {*SQUARES, *(() if self.conjugate and not self.arm else ("counter_base_radius",)),
                  *(("cutter_radius",) if self.face else ("face_width",))}
        # what every cam keeps, then what is asked for; of limits of other kinds nothing is said
        self.limits = {"forward": {"kind": "forward"}, "distance": {"kind": "distance"},
                       "no_undercut": {"kind": "profile_radius", "min_mm": ZERO}}
        for k, limit in enumerate(limits):
            if get(limit, "kind", str) in MEET and limit["kind"] not in others:
                for name in fields(kind_of(limit, *MEET)):
                    good = limit.get(name) is None or get(limit, name) >= 0
                    demand(good, f"limits/{k} has a negative value")
                    if name[-3:] == "deg" and limit[name] is not None:
                        tangent(limit[name])
                if limit["kind"] == "face_width":
                    limit = {"kind": "face_width", "reach": self.ends_of_face(limit)}
            else:
                limit = UNKNOWN
            self.limits[f"limits/{k}"] = limit
        for segment in self.turning:
            self.limits.update(segment.bounds())
        jerks = [get(x, FIELDS["jerk"]) for x in self.limits.values() if x["kind"] == "jerk"]
        self.jerk = min(jerks) / rate**3 if jerks else None
        self.heights, self.known = [ZERO, None], {}  # s0; X and U at places
        self.bent, self.waves = {}, {}  # what is derived once
        self.aim = None  # the prime radius below which there is no cam, if rounds have a larger one

    def prime(self, radius):
        return max(radius + self.gap, ZERO)

    def smaller(self, radius):
        """The prime radius of a base radius, or the largest one if that is smaller."""
        return min(r for r in (self.prime(radius), self.radii[1]) if r is not None)

    def ends_of_face(self, limit):
        """How far contact may be on both sides of a slide's line, or from a pivot's foot on it."""
        ours = ("near_mm", "far_mm") if self.swung else ("left_mm", "right_mm", "width_mm")
        other = [name for name in fields("face_width") if name not in ours]
        demand(not any(limit.get(name) for name in other), "it is no width of this face")
        low, high, *width = (limit[name] for name in ours)
        if self.swung:
            return [low if low is None else -low, high]
        half = [w / 2 for w in width if w is not None]
        return [min(half + [end] * (end is not None), default=None) for end in (low, high)]

    def highest(self, aim=None):
        """The largest s0, of a face Rb/cos tilt, of an arm over its length; None where open."""
        radius = min((x for x in (aim, self.radii[1], self.top) if x is not None), default=None)
        if radius is None or self.arms[0] is None:
            return None
        demand(self.arms[0] > 0, "an arm without a length")
        most = radius / (circle(self.tilt)[1][0] * self.arms[0])
        return -floor(-most) if self.arm else most

    def room(self, order, most):
        """What a mean square leaves to free laws: its integral less what given laws take of it."""
        left = 360 * most**2 / self.rate ** (2 * order)
        for segment in self.turning:
            for piece in () if segment.free else pieces_of(segment, None):
                left -= max(piece.square(order)[0], ZERO)
        return left

    def hull(self, segment, x):
        """Lower bounds of X, -X, U, -U, E and -E at a place, with U = v - c e and E = c e."""
        h, d, (low, high), (least, most) = segment.lift, segment.degrees, self.offsets, self.heights
        spend("coefficients", 16 + len(self.known))
        demand(None not in (low, high, most), "a size has no range")
        e = [min(low * c for c in C), min(-high * c for c in C)]
        if not segment.free:
            (s, t), (v, w) = (segment.given(k, x) for k in (0, 1))
            return [s + segment.level + least, -t - segment.level - most, v + e[1], -w + e[0], *e]
        nodes = sorted(y for (index, y), b in self.known.items()
                       if index == segment.index and None not in b)
        left, right = [y for y in nodes if y <= x], [y for y in nodes if y >= x]
        demand(left and right and self.jerk is not None, "nothing bounds the path of the roller")
        p, q = ([sign * b for sign, b in zip((1, -1, 1, -1), self.known[segment.index, y])]
                for y in (left[-1], right[0]))
        before, after = d * (x - left[-1]), d * (right[0] - x)
        width = before + after
        # |U''| <= jerk: U leaves its chord by no more than this; v = U + E between both places
        chords = [(p[k] * after + q[k] * before) / width if width else p[k] for k in (2, 3)]
        speeds = [min(p[k + 2], q[k + 2]) - self.jerk * width**2 / 8 + e[k] for k in (0, 1)]
        if segment.forward:
            speeds[h < 0] = max(speeds[h < 0], ZERO)
        far = [max(p[k] + before * speeds[k], q[k] + after * speeds[1 - k]) for k in (0, 1)]
        return [*map(floor, far), *(floor(u - self.jerk * before * after / 2) for u in chords), *e]

    def bent_row(self, segment, limit, x, side, touch):
        """A row that differs from place to place, as one of g."""
        place = segment.index, x, id(limit), side, touch
        if place not in self.bent:
            row = (self.face_row(segment, limit, x, side) if self.face else
                   self.swing_row(segment, limit, x, side, touch) if self.arm else
                   self.bend_row(segment, limit, x, side))
            self.bent[place] = scaled(segment, row)
        return self.bent[place]

    def bend_row(self, segment, limit, x, flank=1):
        """A row that a roller's profile radius implies where X, U and E are in the hull.

        side a >= A - B, A and B convex. A is of degree 1, so nowhere below its tangents; B less a
        linear function is largest at a corner of the hull.
        """
        way = 1 if limit["kind"] == "profile_radius" else -1
        gaps = [gap for side, gap, _, path in self.flanks if side == flank and path == 0]
        demand(gaps, "there is no such flank")
        side, radius = way * flank, way * gaps[0] + get(limit, FIELDS[limit["kind"]])
        low, high = (z := self.hull(segment, x))[::2], [-y for y in z[1::2]]
        demand(radius > 0 and low[0] > 0, "it says nothing here")

        def convex(x, u, e):
            sharp = root((C[1] * x) ** 2 + u * u) ** 3 / (C[0] * radius * x)
            return sharp + (e * e / (8 * x) if side > 0 else
                            C[1] ** 2 * x + 2 * (u + e / 4) ** 2 / x)

        mean = [y + z for y, z in zip(low, high)]
        q = floor((mean[1] + mean[2] / 4) / mean[0]) if side > 0 else floor(mean[2] / mean[0])
        slopes = (C[0] ** 2 - 2 * q * q, 4 * q, q) if side > 0 else (-q * q / 8, ZERO, q / 4)
        corners = [(z, convex(*z)) for z in product(*zip(low, high))]
        turns = [floor(sum(b if z[k] == high[k] else -b for z, b in corners) / (4 * (y - w)))
                 if w < y else ZERO for k, (w, y) in enumerate(zip(low, high))]
        most = -floor(min(sum(m * y for m, y in zip(turns, z)) - b for z, b in corners))
        b, c, d = (floor(p - m) if k == 0 else p - m for k, (p, m) in enumerate(zip(slopes, turns)))
        return [b, c, -side * ONE, ZERO], [d - c, b], most  # times X, rounded down: X > 0

    def swings(self, segment, x):
        """Where s of an arm lies at a place [deg]: between its ends, and what rounds have shown."""
        ends, way = (segment.level, segment.level + segment.lift), 1 if segment.lift > 0 else -1
        if not segment.free:
            return [segment.level + end for end in segment.given(0, x)]
        known = [(way * (x - y), *bounds) for (index, y), bounds in self.known.items()
                 if index == segment.index and (y == x or segment.forward)]
        known += [(0, min(ends), max(ends))] if segment.forward else []
        return [max((low for far, low, *_ in known if far >= 0 and low is not None), default=None),
                min((high for far, _, high, *_ in known if far <= 0 and high is not None),
                    default=None)]

    def arcs(self, low, high):
        """A swing, its sine and its cosine all along a range, in parts, as polynomials."""
        if (low, high) not in self.waves:
            count = (high - low) // 3 + 1
            spend("coefficients", 100 * int(count))
            ends = [low + (high - low) * Fraction(k, count) for k in range(count + 1)]
            lines = map(enclose, zip(ends, ends[1:]))
            self.waves[low, high] = [(line, *waves(line)) for line in lines]
        return self.waves[low, high]

    def face_row(self, segment, limit, x, side):
        """What a limit on a face that swings asks of its size where the motion is known.

        What it leaves to spare is affine in p and the base radius; neither is negative.
        """
        found = None if segment.free else self.row_of_path(segment, limit, side)
        demand(found, f"it says nothing of program/{segment.index}")
        s, v, a = (enclosed(segment.given(k, x)) for k in range(3))
        piece = Piece(segment, ZERO, ONE, [s + segment.level, v, a])
        sizes = [(UNITY * p, UNITY * (r + self.away)) for p, r in ((0, 0), (1, 0), (0, 1))]
        rest, *more = (piece.on_arm(1, self.sense, ZERO, *size, self.away)[0].spare(found)
                       for size in sizes)
        rest, p, r = (Fraction(b[0][1], UNIT) for b in (rest, *(b - rest for b in more)))
        return [ZERO] * 4, [-p * self.sense, -r], rest + p

    def swing_row(self, segment, limit, x, side, touch):
        """A row that the pressure angle of an arm implies where the size is in its box.

        side v <= F = s0 (T cos s - side k sin s) + e (T k sin s + side cos s)
        + T sin s + side k (cos s - 1), k the sense. At each s, F is linear in e and s0, so F less
        a plane is largest at a corner of the box; along s it is at most its largest coefficient.
        """
        most = limit[f"{segment.sense}_deg"]
        demand(most is not None, f"it says nothing of program/{segment.index}")
        spend("coefficients", 40 + len(self.known))
        (low, high), box = self.swings(segment, x), (self.offsets, self.heights)
        demand(None not in (low, high, *box[0], *box[1]), "a size or a swing has no range")
        low, high, slope, k = floor(low), -floor(-high), -floor(-tangent(most)[1]), self.sense
        # F = A cos s + B sin s - side k
        corners = [(e, s0, slope * s0 + side * (e + k), slope * (1 + k * e) - side * k * s0)
                   for e, s0 in product(*box)]
        mean = [floor(sum(corner[i] for corner in corners) / 4) for i in (2, 3)]
        (sine, cosine), *ends = ([floor(sum(part) / 2) for part in circle(at)] for at in (
            min(max(touch, low), high), low, high))
        steep = floor(C[0] * (mean[1] * cosine - mean[0] * sine))  # any slopes would do
        if mean[0] * cosine + mean[1] * sine < 0 and low < high:
            first, last = (mean[0] * y + mean[1] * x for x, y in ends)
            steep = floor((last - first) / (high - low))
        size = [slope * k * sine + side * cosine, slope * cosine - side * k * sine]
        rest = []
        for line, sines, cosines in self.arcs(low, high):
            spend("coefficients", 10)
            plane = line * steep
            rest += [max(y for _, y in cosines * a + sines * b - plane) - UNIT * (
                size[0] * e + size[1] * s0 + side * k) for e, s0, a, b in corners]
        return [-steep, side * ONE, ZERO, ZERO], [-x for x in size], -floor(-max(rest) / UNIT)

    def pivot(self, side):
        """How far an arm's pivot is from the axis at most (side 1) or at least, over its length."""
        distance = None if None in self.arms else self.distances[side > 0]
        return None if distance is None else max(distance / self.arms[side < 0], ZERO)

    def empty(self, radius):
        """Whether no size of what swings is in the box of e and s0, by squares alone."""
        k, (e, f), (r, t) = self.sense, self.offsets, (q + self.away for q in self.heights)
        low, high = self.pivot(-1), self.pivot(1)

        def least(x, y):
            return max(x, -y, ZERO) ** 2

        p, q = sorted((1 + k * e, 1 + k * f))
        beyond = least(e, f) + least(r, t) > radius**2 if self.arm else self.heights[0] > radius
        return beyond or (
            high is not None and least(p, q) + least(r, t) > high**2) or (
            low is not None and max(p * p, q * q) + max(r * r, t * t) < low**2)

    def distance_row(self, side):
        """What the distance of a pivot from the axis asks of e and s0 in their box.

        At most: a tangent of the circle; at least: (p - p1)(p - p2) <= 0 on [p1, p2].
        """
        distance, k = self.pivot(side), self.sense
        if None in (distance, *self.offsets, *self.heights):
            return None
        (p, q), (r, t) = (1 + k * e for e in self.offsets), (x + self.away for x in self.heights)
        m = (p + q) / 2, (r + t) / 2
        rest = m[0] + m[1] * self.away
        if side > 0:
            return [ZERO] * 4, [k * m[0], m[1]], root(m[0] ** 2 + m[1] ** 2) * distance - rest
        return [ZERO] * 4, [-2 * k * m[0], -2 * m[1]], 2 * rest - distance**2 - p * q - r * t

    def bends(self, limit):
        """Whether the rows of a limit differ from place to place."""
        of_face = ("pressure_angle", "profile_radius", "face_width") if self.swung else ()
        of_roller = ("pressure_angle",) if self.arm else ("profile_radius", "cutter_radius")
        return limit["kind"] in (of_face if self.face else of_roller)

    def row_of_motion(self, segment, limit, side):
        """What a limit asks of one derivative, factor s^(k) <= most: k, factor, most; or None."""
        kind = limit["kind"]
        if kind in ORDERS:
            return ORDERS[kind], side, get(limit, FIELDS[kind]) / self.rate ** ORDERS[kind]
        if kind == "forward" and segment.forward and side > 0:
            return 1, -segment.lift, ZERO
        if kind == "within" and limit["of"] is segment and limit["ends"][side > 0] is not None:
            return limit["order"], side, side * limit["ends"][side > 0]
        return None

    def row_of_path(self, segment, limit, side):
        """What a limit asks along a path, f X + g u + h s'' <= most; or None.

        f and most are constants. A face that swings is as Piece.on_arm has it.
        """
        kind, bound = limit["kind"], limit.get(f"{segment.sense}_deg")
        if kind == "pressure_angle" and bound is not None:
            if not self.face:
                return -enclosed(tangent(bound)), side, 0, UNITY * 0
            if self.swung:  # |distance from the pivot| <= u tan
                return UNITY * 0, -1, 0, enclosed(1 / t for t in tangent(bound)) * -abs(self.away)
            return UNITY * 0, 0, 0, UNITY * (bound - abs(self.tilt))
        if kind == "face_width" and limit["reach"][side > 0] is not None:
            # along the face contact is at s' - X tan - offset/cos, seen from the slide's line
            reach, turn = limit["reach"][side > 0], (self.tilt > 0) - (self.tilt < 0)
            slope = enclosed(tangent(abs(self.tilt))) * turn if turn else UNITY * 0
            return slope * -side, side, 0, self.lean * (side * self.offset) + reach
        if kind == "profile_radius" and self.face and side > 0:
            return -UNITY, 0, -1, UNITY * -get(limit, "min_mm")
        return None

    def row_of_force(self, segment, limit, side):
        """What a contact force asks of a slide: side G <= most, where sigma G = N cos alpha."""
        try:
            load = self.loaded = self.loaded or Load(self, {})
        except Failure:  # the spring comes with the cam, or it is another load
            return None
        rest, ((low, high),) = [], self.cosine  # of a face; that of a roller is 1, or 0 at least
        if limit["max_n"] is not None and any(
                (-flank if path else flank) == side for flank, _, _, path in self.flanks):
            rest.append(limit["max_n"] * Fraction(high, UNIT))
        if limit["min_n"] is not None and self.flanks[0][0] == -side:
            rest.append(-limit["min_n"] * Fraction(low * self.face, UNIT))
        if not rest:
            return None
        course, ((constant, _),) = load.along(segment.begin, segment.degrees), load.constant * side
        known = Fraction(constant, UNIT) + min(side * y for _, ends in course for y in ends)
        return [*(side * f for f in load.factors), ZERO], [ZERO] * 2, min(rest) - known

    def row(self, segment, limit, side):
        """A row that every cam keeps, alpha . (s, v, a, j) + size . z <= rhs, or None."""
        none, found = [ZERO] * 2, self.row_of_motion(segment, limit, side)
        if limit["kind"] == "distance":
            return self.distance_row(side) if self.swung else None
        if limit["kind"] == "contact_force":
            return None if self.swung else self.row_of_force(segment, limit, side)
        if found:
            order, factor, most = found
            return [factor * ONE if i == order else ZERO for i in range(4)], none, most
        found = None if self.swung or self.bends(limit) else self.row_of_path(segment, limit, side)
        if not found or (self.face and limit["kind"] == "pressure_angle"):
            return None
        # times c, or c^2 with s'', over the cosine of the tilt; s + z is -deep at least
        (steep, along, bent, most), deep = found, segment.depth(self.jerk) if self.face else ZERO
        power = DEGREE * DEGREE if bent else DEGREE
        ((low, high),), ((_, rest),) = steep * power, most * power * self.lean
        if deep is None and low < high:
            return None
        low, rest = Fraction(low, UNIT), Fraction(rest + (high - low) * (deep or 0), UNIT)
        return [low, along * ONE, bent * ONE, ZERO], [-along * (not self.face) * ONE, low], rest

# Step 3. Irrational numbers between two fractions. Of pi the first 40 decimals; a degree is C.
C = [Fraction(31415926535897932384626433832795028841971 + k, 180 * 10**40) for k in (0, 1)]

@lru_cache(maxsize=None)
def circle(degrees):
    """Sine and cosine of an angle up to a turn; neither changes faster than the angle.

    In integers over 2^192: a term is rounded by 1, which later ones multiply by 87 at most.
    """
    demand(abs(degrees) <= 360, "an angle is larger than a turn", 2)
    x, more, found = degrees * C[0] * (1 << 192) // 1, abs(degrees) * (C[1] - C[0]), []
    more = Fraction(more * UNIT // 1 + 2, UNIT)
    for power in (1, 0):
        term, terms = x if power else 1 << 192, []
        for k in range(power, 64 + power, 2):
            terms.append(term)
            term = -(term * x * x // ((k + 1) * (k + 2)) >> 384)
        low, high = sorted((sum(terms[:-1]), sum(terms)))
        found.append((Fraction(low >> 72, UNIT) - more, Fraction((high >> 72) + 1, UNIT) + more))
    return found

def tangent(degrees):
    demand(0 < degrees < 90, "an angle is not between 0 and 90 degrees", 2)
    sine, cosine = circle(degrees)
    demand(cosine[0] > 0, "the tangent of an angle so near to 90 degrees is not enclosed")
    return (Fraction(sine[0] / cosine[1] * UNIT // 1, UNIT),
            -Fraction(-sine[1] / cosine[0] * UNIT // 1, UNIT))

def floor(x):
    return Fraction(x * FINE // 1, FINE)

def root(x):
    return Fraction(isqrt(x * UNIT * UNIT // 1) + 1, UNIT)  # from above

def decimal(x):
    return f"{x * 10**9 // 1 // 10**9}.{x * 10**9 // 1 % 10**9:09d}"

# Step 4. Polynomials on an interval.
class Polynomial(tuple):
    """Bernstein coefficients on [0, 1], each between two integers over UNIT; of a constant one.

    What is added or multiplied is another one, or a fraction.
    """

    def raised(self, size):
        """The same with as many coefficients."""
        more = size - len(self)
        return self * Polynomial([(UNIT, UNIT)] * (more + 1)) if more else self

    def __add__(self, other):
        other = other if isinstance(other, Polynomial) else enclose([other])
        b, c = (p.raised(max(len(self), len(other))) for p in (self, other))
        return Polynomial((x + z, y + w) for (x, y), (z, w) in zip(b, c))

    def __neg__(self):
        return Polynomial((-y, -x) for x, y in self)

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        if not isinstance(other, Polynomial):
            top, bottom = Fraction(other).as_integer_ratio()
            ends = (sorted((x * top, y * top)) for x, y in self)
            return Polynomial((x // bottom, -(-y // bottom)) for x, y in ends)
        n, m = len(self) - 1, len(other) - 1
        b, c = ([(comb(k, i) * x, comb(k, i) * y) for i, (x, y) in enumerate(p)]
                for k, p in ((n, self), (m, other)))
        low, high = [0] * (n + m + 1), [0] * (n + m + 1)
        for i, (x, y) in enumerate(b):
            for k, (z, w) in enumerate(c, i):
                each = x * z, x * w, y * z, y * w
                low[k], high[k] = low[k] + min(each), high[k] + max(each)
        return Polynomial((x // (comb(n + m, k) << BITS), -(-y // (comb(n + m, k) << BITS)))
                          for k, (x, y) in enumerate(zip(low, high)))

    __radd__, __rmul__ = __add__, __mul__

def enclose(low, high=None):
    return Polynomial((x * UNIT // 1, -(-y * UNIT // 1)) for x, y in zip(low, high or low))

def enclosed(ends):
    """A constant between two numbers, in any order."""
    low, high = sorted(ends)
    return enclose([low], [high])

def halves(b, middle):
    spend("halvings of intervals", -(-len(b) // 16))
    left, right = [], []
    while b:  # de Casteljau
        left, right = [*left, b[0]], [b[-1], *right]
        b = [middle(x, y) for x, y in zip(b, b[1:])]
    return left, right

def split(b, t):
    """A polynomial on both sides of a place on [0, 1], rounded outwards."""
    right, whole = t.as_integer_ratio()
    left = whole - right
    return map(Polynomial, halves(b, lambda x, y: (
        (x[0] * left + y[0] * right) // whole, -(-(x[1] * left + y[1] * right) // whole))))

UNITY, DEGREE, PI, PER_RADIAN, INVERSE = map(enclosed, (  # degrees per radian; inverse of pi
    (ONE, ONE), C, [180 * c for c in C], [1 / c for c in C], [1 / (180 * c) for c in C]))

def sine(order, last=28):
    """A derivative of sin(pi u / 2), 0 <= u <= 1, in powers of u, its remainder in the first one.

    The terms alternate and shrink: what is left out is less than the first of them.
    """
    power, found = UNITY, []
    for i in range(last + 1):
        if i >= order:
            sign = (-1) ** (i // 2) if i % 2 else 0
            found.append(power * Fraction(sign, factorial(i - order)))
        power = power * PI * Fraction(1, 2)
    ((_, rest),) = power * Fraction(1, factorial(last + 1 - order))
    found[0] += Polynomial([(-rest, rest)])
    return found

def bernstein(c):
    """The polynomial sum c_i y^i, of pairs."""
    c = [(x // comb(len(c) - 1, i), -(-y // comb(len(c) - 1, i))) for i, (x, y) in enumerate(c)]
    return Polynomial(tuple(sum(comb(m, i) * pair[end] for i, pair in enumerate(c[: m + 1]))
                            for end in (0, 1)) for m in range(len(c)))

def cut(b):
    """A polynomial of degree TERMS at most, with what the powers left out come to at most."""
    wide, b, c, m = max(y - x for x, y in b), [x for x, _ in b], [], len(b) - 1
    while b:  # c_k is comb(m, k) times the k-th difference; b is at most so much wider
        c.append((comb(m, len(c)) * b[0],) * 2)
        b = [y - x for x, y in zip(b, b[1:])]
    rest = sum(abs(x) for x, _ in c[TERMS + 1 :])
    return bernstein(c[: TERMS + 1]) + Polynomial([(-rest, rest + wide)])

def waves(degrees):
    """Sine and cosine of a polynomial in degrees, by Taylor's formula about a whole degree."""
    at = Fraction((degrees[len(degrees) // 2][0] + UNIT // 2) >> BITS)
    y, power, parts = DEGREE * (degrees - at), UNITY, [UNITY * 0] * 2  # of cosine and sine of y
    for k in range(TERMS):
        parts[k % 2] += power * Fraction((-1) ** (k // 2), factorial(k))
        power = cut(power * y)
    rest = max(max(-x, z) for x, z in power) // factorial(TERMS) + 1  # |y|^TERMS: even
    cosine, sine = (part + Polynomial([(-rest, rest)]) for part in parts)
    up, along = map(enclosed, circle(at))
    return up * cosine + along * sine, along * cosine - up * sine

@lru_cache(maxsize=None)
def parts_of(law):
    """The parts of a given law g on [0, 1]: start, width, and g with four derivatives.

    A part is the sum of p_i y^i and q sin(pi y / 2w), y measured from one end, w its width.
    """
    none, found, at = UNITY * 0, [], ZERO
    if law in SCCA:
        (b, c, d), square = (Fraction(x, 40) for x in SCCA[law]), INVERSE * INVERSE
        flat = 1 - b - c - d
        v1, s1 = INVERSE * b, INVERSE * (b * b / 2) - square * (b * b)
        v2, s2 = v1 + c / 2, s1 + v1 * (c / 2) + c * c / 8
        v3, s3 = v2 + INVERSE * d, s2 + v2 * (d / 2) + square * (d * d)
        end = s3 + v3 * (flat / 2)
        ((low, high),) = end
        peak = enclosed((Fraction(UNIT, 2 * high), Fraction(UNIT, 2 * low)))  # as g(1/2) = 1/2
        parts = [(b / 2, 1, [none, v1], square * (-b * b)),
                 (c / 2, 1, [s1, v1, UNITY * Fraction(1, 2)], none),
                 (d / 2, -1, [s3, v2], square * (d * d)), (flat / 2, -1, [end, v3], none)]
        parts = [(w, way, [x * peak for x in p], a * peak) for w, way, p, a in parts if w]
    else:
        lowest, *c = POLYNOMIALS.get(law, (1, 1))
        parts = [(ONE, 1, [none] * lowest + [UNITY * x for x in c], none)]
    for w, way, p, a in parts:
        orders, y = [], way * w  # of y at u = 1
        for k in range(5):
            c = [x * (Fraction(factorial(i), factorial(i - k)) * y**i / y**k)
                 for i, x in enumerate(p) if i >= k] or [none]
            wave = [a * x * (way / y**k) for x in sine(k)] if any(*a) else []
            c = [x + z for x, z in zip_longest(c, wave, fillvalue=none)]
            orders.append(Polynomial(bernstein([pair for (pair,) in c])[::way]))
        found.append((at, w, orders))
        at += w
    if at < 1:  # the second half is 1 - g(1 - x)
        for start, w, orders in found[::-1]:
            turned = [Polynomial(b[::-1]) * -((-1) ** k) for k, b in enumerate(orders)]
            turned[0] += 1
            found.append((1 - start - w, w, turned))
    return found

def given(law, k, x):
    """A derivative of a given law at a place on [0, 1]: two fractions."""
    start, w, orders = [part for part in parts_of(law) if part[0] <= x][-1]
    spend("coefficients", len(orders[k]))
    before, _ = split(orders[k], (x - start) / w)
    return tuple(Fraction(x, UNIT) for x in before[-1])

class Piece:
    """A piece of the motion: s, v, a, j and the next in Bernstein form, and where it lies [deg].

    Of a path also the offset e, X, s' and s'' as lengths, the arm's length, by how much of s' it
    turns, and by how much of the cam's turn a face and the cam do.
    """

    both, arm = UNITY, ONE

    def __init__(self, segment, start, width, orders):
        self.segment, self.start, self.width, self.s = segment, start, width, orders

    def on_slide(self, factor, e, s0):
        """The path of what a slide holds, whose motion is a factor (a pair) times the piece's."""
        found = copy(self)
        found.x, v, a = (factor * b for b in self.s[:3])
        found.x, found.e, found.turn = found.x + s0, enclose([e]), UNITY * 0
        found.slope, found.bend = v * PER_RADIAN, a * PER_RADIAN * PER_RADIAN
        return [found]

    def on_arm(self, way, sense, arm, p, q, away=None):
        """The path of what an arm holds, which turns way times as the piece says, in parts.

        (p, q) is the axis as seen from the pivot, along the arm and square to it, where s = 0. Of a
        face, so far away from the pivot, u is contact from the pivot's foot times ``both``, w, and
        X + s'' is w^3 times the profile's radius.
        """
        parts, found = [(self.start, self.width, self.s[:3])], []
        while parts:
            start, width, orders = parts.pop()
            spend("coefficients", 400)
            y, v, a = (cut(b) * way for b in orders)
            sine, cosine = waves(y)
            if any(high - low > SHARP for b in (y, v, a, sine, cosine) for low, high in b):
                left, right = zip(*(split(b, Fraction(1, 2)) for b in orders))
                parts += [(start + width / 2, width / 2, right), (start, width / 2, left)]
                continue
            part = Piece(self.segment, start, width, orders)
            part.x, along, a = q * cosine + p * sine, p * cosine - q * sine, a * PER_RADIAN
            part.e, part.turn = (along - arm) * sense, v * sense
            part.slope, part.bend, part.arm = v * arm, a * arm, arm
            if away is not None:
                w, high = part.turn + 1, part.x
                part.x, part.e, part.slope, part.both = high - away, UNITY * 0, along, w
                part.bend = high * (part.turn * 2 + 1) * w + along * a - w * w * w * away - part.x
            found.append(part)
        return found

    def curve(self):
        """W^2 and the numerator N of a roller's path; its curvature is N/W^3."""
        u = self.slope - self.e
        w = self.x * self.x + u * u
        return w, w + self.slope * u * (self.turn + 1) - self.bend * self.x

    def spare(self, row):
        """What a row of its path leaves to spare."""
        steep, along, bent, most = row
        most = most * (self.both * self.both * self.both if bent else self.both)
        return most - steep * self.x - (self.slope - self.e) * along - self.bend * bent

    def square(self, order):
        """The integral of (s^(order))^2: the mean of the coefficients."""
        b = self.s[order] * self.s[order]
        spend("coefficients", len(b))
        return [self.width * Fraction(sum(ends), len(b) * UNIT) for ends in zip(*b)]

    def part(self, first, last):
        """What lies between two places on [0, 1], rounded outwards; at one place numbers."""
        def between(b):
            b, _ = split(b, last)
            return [*split(b, first / last)][1] if first < last else Polynomial(b[-1:])

        if (first, last) == (0, 1):
            return self
        found, known = copy(self), vars(self).items()
        vars(found).update({name: between(b) for name, b in known if isinstance(b, Polynomial)},
                           start=self.start + first * self.width, s=[between(b) for b in self.s],
                           width=(last - first) * self.width)
        return found

    def root(self, w, powers, least=0):
        """Refuse unless the sum of p_k b^k is at least so much everywhere, for some b > 0.

        ``powers``: polynomials p_k, or numbers, by k. Any b will do: on each part one next to the
        root of w.
        """
        known = [k for k, p in powers.items() if isinstance(p, Polynomial)]
        top, size = max(powers), max(len(powers[k]) for k in known)

        def test(near, *each):
            b = isqrt(max(near[len(near) // 2], 1))  # over the root of UNIT
            by = {k: b**k << BITS // 2 * (top - k) for k in powers}
            rest = sum(UNIT * p * by[k] for k, p in powers.items() if k not in known) - least
            return all(rest + sum(by[k] * p for k, p in zip(known, b)) >= 0 for b in zip(*each))

        self.show(w, *(powers[k].raised(size) for k in known), test=test)

    def show(self, *polynomials, least=0, test=None):
        """Refuse unless a test of lower coefficients holds on parts that cover the piece.

        The basis is nowhere negative: with smaller coefficients a polynomial is smaller. Without a
        test all have to be at least so much, in integers: 1 is above 0.
        """
        test = test or (lambda *each: min(map(min, each)) >= least)
        spend("coefficients", sum(map(len, polynomials)))
        parts = [([[low for low, _ in p] for p in polynomials], 0, ZERO)]
        while parts:
            each, depth, at = parts.pop()
            if not test(*each):
                place = decimal(self.start + at * self.width)
                demand(depth < DEEPEST, f"program/{self.segment.index}, {place} deg from its start")
                left, right = zip(*(halves(b, lambda x, y: (x + y) >> 1) for b in each))  # down
                parts += [(right, depth + 1, at + Fraction(1, 2 << depth)), (left, depth + 1, at)]

def pieces_of(segment, law):
    """A segment's pieces: a straight line, or the spline with these knots and coefficients."""
    h, d, level, found = segment.lift, segment.degrees, segment.level, []
    if not segment.free:
        demand(law is None, f"program/{segment.index} has a law", 2)
        for start, w, orders in parts_of(segment.law):
            orders = [b * (h / d**k) for k, b in enumerate(orders)]
            orders[0] += level
            found.append(Piece(segment, d * start, d * w, orders))
        return found
    p, (t, c) = whole(law, "degree", 1, 5), (
        numbers(get(law, name, list)) for name in ("knots", "coefficients"))
    good = t[:1] + t[-1:] == [0, 1] and all(x < y for x, y in zip(t, t[1:]))
    good = good and segment.smooth < p and len(c) == len(t) - 1 + p
    good = good and c[:1] + c[-1:] == [0, 1]  # the lift is the program's
    demand(good, f"the spline of program/{segment.index} is not of the class asked for")
    spend("coefficients", 100 * (len(c) - p))
    t = [ZERO] * p + t + [ONE] * p
    for j in range(len(c) - p):
        s, start, end = [], t[p + j], t[p + j + 1]
        for k in range(p + 1):  # coefficient k is the blossom at start, p - k times, and at end
            row = c[j : j + p + 1]
            for r in range(1, p + 1):
                x, around = start if r <= p - k else end, zip(t[j + r :], t[j + p + 1 :])
                row = [((v - x) * y + (x - u) * z) / (v - u)
                       for (u, v), y, z in zip(around, row, row[1:])]
            s.append(level + h * row[0])
        orders, width = [s], d * (end - start)
        for _ in range(4):
            s = [(len(s) - 1) * (y - x) / width for x, y in zip(s, s[1:])] or [ZERO]
            orders.append(s)
        found.append(Piece(segment, d * start, width, [enclose(s) for s in orders]))
    return found

class Load:
    """What loads a follower along its motion: in N, of what swings about its pivot in N mm."""

    def __init__(self, question, chosen):
        self.body, unit, speed = question.load, 1000 if question.swung else 1, question.rate
        kind = kind_of(self.body, "arm" if question.swung else "slide")
        mass, damping = (get(self.body, name) for name in [*fields(kind)][:2])
        spring, rate, preload = self.body["spring"], ZERO, ZERO
        if spring is not None:  # what is left open is not negative
            rate, preload = (choose({"min": ZERO, "max": None} if spring[name] is None else
                                    spring[name], chosen.get(name))
                             for name in [*fields(kind_of(spring, f"{kind} spring"))][:2])
        demand(min(mass, damping, rate, preload) >= 0, "a mass, a damping or a spring is negative")
        turn, inert = (DEGREE * 1000,) * 2 if question.swung else (ONE, MILLI)
        self.factors = turn * rate, inert * (damping * speed), inert * (mass * speed**2)
        side, tilt = question.flanks[0][0], self.body.get("rise_from_vertical_deg")
        self.constant = UNITY * (side * preload * unit)
        if tilt is not None:
            self.constant += enclosed(circle(tilt)[1]) * (mass * GRAVITY)
        known = [[get(each, name) for name in fields(kind_of(each, f"{kind} process"))]
                 for each in get(self.body, "process", list)]
        known = [(x, y * unit) for x, y in known] or [(ZERO, ZERO)]
        (x, y), (z, w) = known[0], known[-1]
        self.process = [(z - 360, w), *known, (x + 360, y)]  # straight lines between
        self.breaks = [x for x, _ in self.process]
        good = self.breaks == sorted(self.breaks) and x >= 0 and z <= 360
        demand(good, "the process force goes back, or lies beyond the turn")

    def along(self, start, width):
        """The process force on a part of the turn: ends of its straight lines there, and values."""
        first = bisect(self.breaks, start) - 1
        for (x, y), (z, w) in zip(self.process[first:], self.process[first + 1:]):
            ends = [max(x - start, ZERO), min(z - start, width)]
            if ends[0] >= width:
                return
            if ends[0] < ends[1]:
                spend("coefficients")
                yield ends, [y + (w - y) * (start + end - x) / (z - x) for end in ends]

    def on(self, piece):
        """A piece between the breaks of the process force, part by part, and the force there."""
        for ends, process in self.along(piece.segment.begin + piece.start, piece.width):
            part = piece.part(*(end / piece.width for end in ends))
            yield part, sum((f * b for f, b in zip(self.factors, part.s)),
                            self.constant + enclose(process))

    def stiffness(self):
        """Of the line contact: p^2 times this is the force, times the sum of both curvatures."""
        width, *both = (self.body["contact"][each] for each in fields(
            kind_of(self.body["contact"], "line contact")))
        both = [[get(each, name) for name in fields(kind_of(each, "material"))] for each in both]
        good = width > 0 and all(e > 0 and n * n < 1 for e, n in both)
        demand(good, "a width or a modulus is not positive")
        return PI * (width * sum((1 - n * n) / e for e, n in both))

# Step 5. The cam of the file: what its limits say, at every cam angle.
class Cam:
    def __init__(self, question, body):
        laws, size = get(body, "laws", list), [*numbers(get(body, "size", list))]
        self.question, follower, held = question, question.follower, question.held
        self.spring = body.get("spring") or {}
        # what the size and the counter roller's place have to keep: a value and its range
        self.ranges, free = [], question.arm and isinstance(follower["arm_mm"], (dict, type(None)))
        good = len(laws) == len(question.program) and len(size) == (
            2 - (question.face and not question.swung) + question.conjugate + free)
        demand(good, "the cam has not as many laws or sizes as it must have", 2)
        self.pieces = [piece for s in question.turning for piece in pieces_of(s, laws[s.index])]
        if question.swung:
            arm = ZERO if question.face else size.pop() if free else get(follower, "arm_mm")
            demand(question.face or arm > 0, "an arm without a length")
            sense, (p, q) = question.sense, size[:2]
            self.ranges.append((p * p + q * q, range_of(follower["centre_distance_mm"]), 2))
            if not question.face:
                self.ranges.append((arm, range_of(follower["arm_mm"]), 1))
            away = question.away if question.face else None
            paths = [(1, sense, arm, UNITY * p, UNITY * q, away)]
            if question.conjugate:  # as far beyond the axis as the angle between both arms says
                self.ranges.append((size[2], range_of(held["angle_deg"]), 1))
                sine, cosine = map(enclosed, circle(size[2]))
                paths.append((-1, -sense, get(held, "arm_mm"), cosine * p + sine * q,
                              sine * p - cosine * q))
            size = [ZERO, q - question.away] if question.face else [p - arm, q]
        else:
            size = [ZERO] * question.face + size
            paths = [(question.cosine, *size[:2])]
            if question.conjugate:  # upside down
                self.ranges.append((size[2], range_of(held["distance_mm"]), 1))
                paths.append((-UNITY, -get(held, "offset_mm"), size[2] - size[1]))
            self.ranges.append((size[0], question.offsets, 1))
        held_by, self.size = Piece.on_arm if question.swung else Piece.on_slide, size[:2]
        self.paths = [[part for each in self.pieces for part in held_by(each, *path)]
                      for path in paths]
        for piece in self.paths[0] if question.swung and question.face else ():
            piece.show(piece.both, piece.slope, piece.x, least=1)  # contact on its own side

    def join(self, order, limit=UNKNOWN):
        """Refuse jumps of derivatives up to an order; None: up to those that the question asks for.

        Of a window or point only where it is.
        """
        for left, right in zip(self.pieces, self.pieces[1:] + self.pieces[:1]):
            one, other, inside, smooth = left.segment, right.segment, right.start > 0, order
            places = (one, (left.start + left.width) / one.degrees), (
                other, right.start / other.degrees)
            if limit is not UNKNOWN and not any(segment is limit["of"] and (
                    limit["from"] <= x <= limit["to"]) for segment, x in places):
                continue
            if order is None:
                smooth = min(one.smooth, other.smooth) if (
                    one.free or other.free) and not inside else 0
                smooth = max(smooth, self.question.smooth)
            if inside and one.free:  # a knot
                demand(len(left.s[0]) - 1 > smooth,
                       f"derivative {smooth} jumps inside program/{one.index}")
            else:
                self.meet(left, right, smooth)

    def meet(self, left, right, smooth):
        """Refuse jumps between two pieces of derivatives up to an order."""
        sides, place = (left, right), "inside" if right.start else "at the start of"
        for k in range(smooth + 1):
            (p, q), (r, t) = left.s[k][-1], right.s[k][0]
            jump = Fraction(max(p - t, r - q, 0), UNIT)  # at least; at most wide more
            scales = [(abs(p.segment.lift) / p.segment.degrees**k, p.segment.degrees / p.width)
                      for p in sides if p.segment.lift]
            wide = Fraction(q - p + t - r, UNIT) if scales else ZERO
            most = min((h * max(1, min(n, 1000) ** k * ROUNDING) for h, n in scales), default=0)
            text = f"derivative {k} jumps {place} program/{right.segment.index}"
            demand(jump + wide <= most * JUMP, text)
            self.jump = max(self.jump, jump / min(scales)[0] if jump else ZERO)

    def keep(self, limit):
        """Show that what a limit leaves to spare is nowhere negative."""
        question, of_motion = self.question, limit["kind"] in (*ORDERS, "forward", "within")
        asked = question.row_of_motion if of_motion else question.row_of_path
        for path, side in product([self.pieces] if of_motion else self.paths, (1, -1)):
            for piece in path:
                found, degrees = asked(piece.segment, limit, side), piece.segment.degrees
                first, last = (((limit[end] * degrees - piece.start) / piece.width)
                               for end in ("from", "to")) if "from" in limit else (ZERO, ONE)
                if not found or last < 0 or first > 1:
                    continue
                piece = piece.part(max(first, ZERO), min(last, ONE))
                if of_motion:
                    order, factor, most = found
                    spare = most + JUMP * limit.get("scale", 0) - piece.s[order] * factor
                else:
                    spare = piece.spare(found)
                piece.show(spare)

    def bend(self, way, least, around=False):
        """X > 0, and the radius of every flank is at least so much where it is convex (way 1) or
        hollow: side N/W^3 <= 1/radius, N/W^3 the curvature of the roller's path.

        3 r W^2 - r^3 <= 2 W^3 for every r > 0. ``around``: X^2 - u e > reach W too, so that the
        profile runs once round the axis; 2 r W <= W^2 + r^2.
        """
        for flank, gap, _, path in self.question.flanks:
            radius, far = max(least + way * gap, ZERO), max(flank * gap, ZERO)
            for piece in self.paths[path]:
                w, n = piece.curve()
                piece.show(piece.x, least=1)
                piece.root(w, {1: w * 3, 3: -1, 0: n * (-2 * way * flank * radius)})
                if around:
                    along = piece.x * piece.x - piece.e * (piece.slope - piece.e)
                    piece.root(w, {1: along * 2, 0: w * -far, 2: -far}, 1)

    def press(self, limit):
        """Contact force N and Hertz pressure p on every flank, and the camshaft's torque T.

        Of a roller N = F W/lever with the lever l X, l the arm's length (1 of a slide), and
        p^2 B = N (1/R + N_c/(W^3 - R N_c)), N_c the curvature's numerator; of a face N = F w/lever
        with w = 1 and the cosine of the tilt, or as Piece.on_arm has both.
        """
        question, kind, load = self.question, limit["kind"], Load(self.question, self.spring)
        high, low = get(limit, FIELDS[kind].split()[0], (Fraction, type(None))), limit.get("min_n")
        for flank, gap, _, path in question.flanks[: 1 if kind == "camshaft_torque" else None]:
            for piece, force in (part for each in self.paths[path] for part in load.on(each)):
                if kind == "camshaft_torque":
                    work = force * piece.s[1] * (UNITY if question.swung else PER_RADIAN) * MILLI
                    piece.show(high - work, high + work)
                    continue
                force, w, lever = force * (-flank if path else flank), UNITY, question.cosine
                if question.face:
                    force, lever = force * piece.both, piece.slope if question.swung else lever
                else:
                    (w, n), lever = piece.curve(), piece.x * piece.arm
                    piece.show(lever, least=1)
                if kind == "contact_force":  # big >= less W, as 2 b W <= W^2 + b^2
                    pairs = [] if high is None else [(lever * high, force)]
                    pairs += [] if low is None else [(force * w, lever * low)]
                    forms = [{1: big * 2, 0: -(less * w), 2: -less} for big, less in pairs]
                elif question.face:
                    both, most = piece.both * piece.both, load.stiffness() * high**2 * lever
                    forms = [{0: most * (piece.x + piece.bend) - force * both * piece.both}]
                else:  # 2 W^3 >= 3 b W^2 - b^3
                    radius = get(question.held if path else question.follower, "roller_radius_mm")
                    most = load.stiffness() * high**2 * lever * radius
                    rest = (force * w * w + most * n * (gap * flank)) * -2
                    forms = [{1: most * w * 3, 3: -most, 0: rest}]
                    if gap > radius:  # W between w (3 b^2 - w)/(2 b^3) and (w + b^2)/(2 b)
                        less = force * n * (flank * (gap - radius))
                        forms = [{4: most * w * 3, 6: -most, 3: rest, 2: less * w * 3,
                                  0: -(less * w * w)},
                                 {2: most * w * 3 + less, 4: -most, 1: rest, 0: less * w},
                                 {1: w * 3, 3: -1, 0: n * (-2 * gap * flank)}]  # no undercut
                for form in forms:
                    piece.root(w, form)

    def reach(self, way, radius):
        """X > 0, and every path is as near to the axis as its cam's largest radius allows (way 1),
        or the counter roller's as far as a least one asks: way (X^2 + e^2) <= way (radius + gap)^2.
        """
        for path, pieces in list(enumerate(self.paths))[way < 0 :]:
            gaps = [side * gap - rim for side, gap, rim, of in self.question.flanks if of == path]
            most = radius + min(gaps)
            demand(most >= 0, "roller and rim alone are larger")
            for piece in pieces:
                far = piece.x * piece.x + piece.e * piece.e
                piece.show(piece.x, least=1)
                piece.show(way * (most * most - far))

    def mean(self, order, most):
        """A mean square, as a sum of integrals."""
        total = sum(piece.square(order)[1] for piece in self.pieces)
        demand(total * self.question.rate ** (2 * order) <= 360 * most**2, "its mean is larger")

    def fit(self):
        """The sizes are in their ranges; of radii and distances the squares, as they are roots."""
        square, most = sum(x * x for x in self.size), max(self.question.gap, ZERO)
        good, miss = self.size[1] >= 0 and square > most**2, ZERO
        for value, ends, power in [*self.ranges, (square, self.question.radii, 2)]:
            low, high = (value if end is None else end if power == 1 else max(end, ZERO) ** 2
                         for end in ends)
            over = max(low - value, value - high)
            miss = max(miss, over / value if over > 0 and power == 2 else over)
            good = good and (power == 2 or over <= 0)
        demand(good and miss <= 2 * GAP, "it is not within the range asked for")
        share = f", the radius but for 1/{2 / miss // 1} of it" if miss > 0 else ""
        return "base radius and offset are in their ranges" + share

    def check(self, place):
        """Show what stands at a place of the list of claims, or refuse."""
        question, self.jump, exact = self.question, ZERO, ""
        if place == "size":
            return self.fit()
        name = {"motion": "forward", "self_crossing": "no_undercut"}.get(place, place)
        limits = [x for each, x in question.limits.items() if f"{each}/".startswith(f"{name}/")]
        demand(limits, "it is not covered")
        for limit in limits:
            kind = limit["kind"]
            demand(kind in MEET or kind in ("forward", "within"), "it is not covered")
            if kind == "within":
                self.join(limit["order"] - 1, limit)
                if limit["scale"]:
                    exact = f", values but for 1/{1 / JUMP} of their scale"
            else:
                self.join(MEET.get(kind))
            if kind in ("outer_radius", "counter_base_radius"):
                self.reach(1 if kind == "outer_radius" else -1, get(limit, FIELDS[kind]))
            elif kind == "cutter_radius":
                self.bend(-1, get(limit, "radius_mm"))
            elif kind == "profile_radius" and not question.face:
                self.bend(1, get(limit, "min_mm"), place == "self_crossing")
            elif kind in FORCES:
                self.press(limit)
            elif kind in SQUARES:
                self.mean(SQUARES[kind], limit["most"])
            else:
                self.keep(limit)
        if place[:8] == "program/":
            return "holds all along" + exact
        share = f", but derivatives jump by 1/{1 / (self.jump or 1) // 1} of their scale at joints"
        return "holds at every cam angle" + (share if self.jump else "")

def scaled(segment, row):
    """A row as one of g and its derivatives."""
    if row is None:
        return None
    alpha, size, rhs = row
    return ([f * segment.lift / segment.degrees**k for k, f in enumerate(alpha)], size,
            rhs - alpha[0] * segment.level)

# Step 6. What the multipliers say of all cams: constant + size . z <= 0.
def half_plane(question, proof, aim=None):
    """``aim``: a segment, a place and factors of (s, v, a, j) and of z, of what is bounded."""
    order = whole(proof, "order", 2, 3)
    kind = {2: "acceleration", 3: "jerk"}[order]
    spend("coefficients", 2 * len(question.program))
    caps = [get(x, FIELDS[kind]) for x in question.limits.values() if x["kind"] == kind]
    cap = min(caps) / question.rate**order if caps else None
    constant, sizes, joints = ZERO, [ZERO] * 2, defaultdict(int)
    kernels_of = defaultdict(lambda: defaultdict(lambda: [ZERO] * 5))
    used = defaultdict(int)  # of each law, up to where tangents of a mean square are known
    squares, price, most = {}, ZERO, None  # of the derivative of this order: multiplier, and room
    for name in proof.get("squares", {}):
        limit, factor = question.limits.get(name, UNKNOWN), get(proof["squares"], name)
        k = SQUARES.get(limit["kind"], 4)
        demand(factor > 0 and k <= order, f"{ascii(name)[:20]} is no mean square, or not limited")
        room = question.room(k, limit["most"])
        constant, squares[name] = constant - factor * room, (k, factor)
        if k == order:
            price, most = price + factor, room if most is None else min(room, most)

    def add(segment, row, x, y, low, high):
        """A row times a multiplier at x, or a density that is linear from there to y."""
        nonlocal constant, sizes
        alpha, size, rhs = row
        spend("coefficients", 8)
        top = order + (x < y)  # the derivative that is limited itself is known almost everywhere
        demand(not (segment.free and any(alpha[top:])), "a row is of too high a derivative")
        mass, kernels = low, [(x, 0, low)]
        if x < y:
            demand(segment.free, "a density on a segment that is not free")
            steep, mass = (high - low) / (y - x), (low + high) / 2 * (y - x)
            kernels = [(y, 1, high), (y, 2, -steep), (x, 1, -low), (x, 2, steep)]
        for at, n, weight in kernels if segment.free else ():
            for k in range(top):
                kernels_of[segment.index][at][order - 1 - k + n] += weight * alpha[k]
        if not segment.free:
            constant += mass * sum(min(f * bound for bound in given(segment.law, k, x))
                                   for k, f in enumerate(alpha) if f)
        constant -= mass * rhs
        sizes = [p + mass * q for p, q in zip(sizes, size)]

    if aim and aim[0] is None:
        sizes = aim[3]
    elif aim:
        segment, x, alpha, size = aim
        demand(segment.free and 0 <= x <= 1, "a place that is not on a free law")
        add(segment, scaled(segment, (alpha, size, ZERO)), x, x, ONE, ZERO)
    for part in get(proof, "segments", list):
        segment = question.program[whole(part, "segment", 0, len(question.program) - 1)]
        h, d, psi = segment.lift, segment.degrees, kernels_of[segment.index]
        ends = numbers(get(part, "ends", list))
        good = segment in question.turning and len(ends) <= order * segment.free
        demand(good, f"program/{segment.index} has no angle, or not so many end conditions")
        # 6.1 Rows times multipliers that are not negative, at points and as linear densities.
        for group in get(part, "rows", list):
            name = get(group, "limit", str)
            limit, side = question.limits.get(name, UNKNOWN), get(group, "side")
            bends = question.bends(limit)
            row = None if bends else scaled(segment, question.row(segment, limit, side))
            of, factor = squares.get(name, (0, ZERO))
            if 0 < of < order:  # of factor (s^(k))^2, tangents
                row = scaled(segment, ([ONE * (i == of) for i in range(4)], [ZERO] * 2, ZERO))
            demand(side in (1, -1) and (row or bends),
                   f"{ascii(name)[:20]} says nothing of program/{segment.index}")
            for x, *more in map(numbers, get(group, "multipliers", list)):
                swings = bends and question.arm
                demand(not swings or len(more) == 2, "a row of an arm is not [x, factor, swing]")
                touch = more.pop() if swings else None
                y, low, high = more if len(more) == 3 else (x, *more, ZERO)
                demand(0 <= x <= y <= 1 and (of or low >= 0 <= high),
                       "a multiplier is negative, or beyond")
                x, y = (min(max(at, limit.get("from", 0)), limit.get("to", 1)) for at in (x, y))
                if bends:
                    count = SLICES if x < y else 1
                    for k in range(count):  # in the middle of each slice
                        t = x + (y - x) * Fraction(2 * k + 1, 2 * count)
                        mass = low if count == 1 else (y - x) / count * (
                            low + (high - low) * Fraction(2 * k + 1, 2 * count))
                        add(segment, question.bent_row(segment, limit, t, side, touch),
                            t, t, mass, ZERO)
                    continue
                if x < y:  # the slope is rounded up, and the end with it
                    high = low - Fraction((low - high) / (y - x) * UNIT // 1, UNIT) * (y - x)
                if of:
                    demand(used[segment.index, name] <= x < y, "tangents overlap, or have no width")
                    used[segment.index, name] = y
                    constant -= (y - x) * (low * low + low * high + high * high) / (
                        12 * factor * d)
                add(segment, row, x, y, low, high)
        for name, bound in (("duration", duration), ("rest", rest)):
            if part.get(name) is not None:  # what every law keeps, whatever limits it
                factor = get(part[name], "factor")
                demand(factor >= 0, "a factor is negative")
                more, size = bound(question, segment, part[name])
                constant += factor * more
                sizes = [p + factor * q for p, q in zip(sizes, size)]
        # 6.2 End conditions are equalities, with multipliers of either sign.
        for k, nu in enumerate(ends):
            psi[ONE][order - 1 - k] += nu
            joints[segment.index, k] -= nu * d**k / h
    # What is left of a law is the integral of psi g^(m), and shares of derivatives at its start.
    for segment in question.turning:
        if segment.free:
            h, d = segment.lift, segment.degrees
            bound = None if cap is None else cap * d**order / abs(h)
            demand(caps or price or not any(map(any, kernels_of[segment.index].values())),
                   f"nothing limits the {kind} of every law")
            area, shares = remainder(
                kernels_of[segment.index], bound, price * segment.square(order))
            constant -= area
            for k in range(1, order):
                joints[segment.before.index, k] += shares[order - 1 - k] * d**k / h
    # 6.3 Derivatives where two segments meet: known, or bounded by Taylor where g stays in [0, 1].
    for (index, k), share in joints.items():
        left, right = question.program[index], question.program[index].after
        known = [(s, end) for s, end in ((left, ONE), (right, ZERO)) if not s.free]
        turns = left.forward and right.forward and left.lift * right.lift < 0
        if k == 0:
            constant += share * left.lift
        elif known:
            (segment, end), *_ = known
            constant += min(share * bound for bound in segment.given(k, end))
        elif share and not (k == 1 and turns):
            demand(right.forward, f"the start of program/{right.index} is not bounded")
            total = root(max(most, ZERO) / right.square(order)) if cap is None else (
                cap * right.degrees**order / abs(right.lift))  # of |g^(order)|
            start = 1 + total if order == 2 else k + 2 + (2 * k - 1) * total
            constant -= abs(share * right.lift) / right.degrees**k * start
    return constant, sizes

def duration(question, segment, body):
    """What the least duration of a move says of the size: constant + size . z <= 0.

    It passes every height upwards, no faster than a row allows, F: the integral of 1/F over all
    heights is d at most. F is affine in s and z, and 1/F >= 2 q - q^2 F for every q.
    """
    constant, sizes, cells = -segment.degrees, [ZERO] * 2, []
    for group in get(body, "rows", list):
        limit, side = question.limits.get(get(group, "limit", str), UNKNOWN), get(group, "side")
        row = question.row(segment, limit, side)
        good = row and side in (1, -1) and "from" not in limit and (
            row[0][1] * segment.lift > 0 and not any(row[0][2:]))
        demand(good, f"it does not limit how fast program/{segment.index} is")
        (steep, along, *_), size, most = row
        for low, high, q in map(numbers, get(group, "cells", list)):
            spend("coefficients", 8)
            cells.append((low, high))
            width, middle = abs(segment.lift) * (high - low), segment.level + (
                segment.lift * (low + high) / 2)
            share = width * q * q / abs(along)
            constant += 2 * width * q - share * (most - steep * middle)
            sizes = [x + share * y for x, y in zip(sizes, size)]
    edges = [ZERO, *(x for cell in sorted(cells) for x in cell), ONE]
    demand(edges == sorted(edges), "heights overlap, or lie beyond the move")
    return constant, sizes

def rest(question, segment, body):
    """How a move comes to rest under a flat face: its radius times sin(angle from an end).

    Two integrations by parts leave s and s' at both ends; s' counts at the other end alone.
    """
    limit, end = question.limits.get(get(body, "limit", str), UNKNOWN), whole(body, "end", 0, 1)
    good = question.face and not question.swung and limit["kind"] == "profile_radius"
    demand(good and segment.free and segment.degrees <= 180, "it is no radius under a face")
    (sine, cosine), way = map(enclosed, circle(segment.degrees)), 1 if end else -1
    near, far = [segment.level, segment.level + segment.lift][::way]
    speed = enclosed(segment.speed(end)) * PER_RADIAN * way
    ((low, _),) = (1 - cosine) * question.lean * get(limit, "min_mm") - (
        sine * speed) + cosine * far - near
    return Fraction(low, UNIT), [ZERO, -Fraction((1 - cosine)[0][1], UNIT)]

def remainder(kernels, cap, weight):
    """An upper bound of -(psi w + weight w^2), summed, and what acts on derivatives at the start.

    |w| <= cap. psi is the sum of all c (x - tau)^n / n! with x > tau: its pieces from the right to
    the left, in integers of a unit that is small beside all c; rounding is less than 100 units a
    cut.
    """
    cuts, area, psi = sorted({ZERO, ONE, *kernels}, reverse=True), [], [0] * 5
    unit = max((abs(c) for each in kernels.values() for c in each), default=ZERO) / (1 << 96)
    shares = [sum(c[j] * x ** (j - i) / factorial(j - i)
                  for x, c in kernels.items() for j in range(i, 5) if c[j]) for i in range(2)]
    if not unit:
        return ZERO, shares
    for right, left in zip(cuts, [*cuts[1:], ZERO]):
        # in powers y^n / n! of y = right - tau, then of y = left - tau
        w = [(right - left) ** i * UNIT // factorial(i) for i in range(5)]
        psi = [p + q // unit for p, q in zip(psi, kernels.get(right, ()))] if (
            right in kernels) else psi
        steps = [p * v >> BITS for p, v in zip(psi, w)]
        area.append(([sum(comb(k, i) * (12 // comb(4, i)) * steps[i] for i in range(k + 1)) // 12
                      for k in range(5)], w[1] + 1))
        psi = [sum(psi[j] * w[j - i] >> BITS for j in range(i, 5)) for i in range(5)]
    # The most is cap h(psi), with h convex: |psi| - edge/2 from |psi| = edge on, below it
    # psi^2/(2 edge), and edge = 2 weight cap. Where the cap is beyond all of -psi/(2 weight), or
    # there is none, the largest |psi| is an edge. Coefficients give 2 h.
    top = max(abs(x) for b, _ in area for x in b) + 1000 * len(cuts)
    edge = top if cap is None else min(top, 2 * weight * cap // unit)
    if edge == top:
        cap = edge * unit / (2 * weight)

    def twice(x, parts=1):
        """2 h of x/parts, times parts."""
        x, top = abs(x), parts * edge
        return 2 * x - top if x >= top else -(-x * x // top)

    # h is at most its mean over coefficients, and at least h of their mean (Jensen).
    total = sum(sum(map(twice, b)) * w for b, w in area)
    spare, total = total // (len(area) << 24), 1000 * len(cuts) * UNIT
    while area:
        b, width = area.pop()
        size = sum(map(twice, b))
        if max(map(abs, b)) < edge:  # psi^2 all along: of degree 8
            size = -(-5 * sum(comb(4, i) * comb(4, j) * (280 // comb(8, i + j)) * p * q
                              for i, p in enumerate(b) for j, q in enumerate(b)) // (2520 * edge))
        elif (size - twice(sum(b), 5)) * width > spare:
            area += [(half, width + 1 >> 1) for half in halves(b, lambda x, y: (x + y) >> 1)]
            continue
        total += (size + 2000) * width
    return cap * total * unit / (10 * UNIT), shares

# Step 7. No size keeps the half-plane and its ranges: then there is no such cam.
def least(question, proof, aim=None):
    """What is aimed at is at least this for every cam; without an aim, if it is above 0 none is."""
    constant, (p, q) = half_plane(question, proof, aim)
    return constant - reach(question, p, q)

def reach(question, p, q):
    """The most that -(p, q) . z comes to, by Cauchy and Schwarz for some parts of it."""
    radius = question.highest()
    demand(radius is not None or p == q == 0, "nothing limits the size from above")
    up, most, bottom = -q, [], question.heights[0]
    heights = [bottom, min(radius or ZERO, question.heights[1] or radius or ZERO)]
    radius = (radius or ZERO) + question.wide
    ends = [f(radius * sign, radius * sign if e is None else e)
            for e, f, sign in zip(question.offsets, (max, min), (-1, 1))]

    def leg(x):  # the other side of a right triangle
        return root(radius * radius - x * x) if x * x < radius * radius else ONE

    for slope in (-p * c for c in question.unit):
        # slope e + up s0 = (slope - y) e + (up - w) s0 + (y e + w s0), by Cauchy and Schwarz
        ys = [(slope, max(up, ZERO)), (ZERO, ZERO),
              *((slope, abs(slope) * height / leg(height)) for height in heights),
              *((up * e / leg(e), up) for e in ends)]
        most.append(min(radius * root(y * y + w * w) + (slope - y) * ends[slope > y]
                        + (up - w) * heights[up > w] for y, w in ys))
    return max(most)

def narrow(question, bounds):
    """Keep bounds of where cams can be that are better than those known."""
    for ends, end, bound in bounds:
        way = (1, -1)[end % 2]
        ends[end] = way * bound if ends[end] is None else way * max(bound, way * ends[end])
    question.bent.clear()

def exclude(question, body):
    """Refuse unless no cam is left, after steps that show where cams can be."""
    small, radius = question.radii
    if small is not None and radius is not None and small > radius:
        return
    demand(not question.face or not ({"rounds", "cases"} & {*body}) or (
        question.swung and "rounds" not in body), "rounds of a flat face")
    most = question.highest()
    if question.heights[1] is None:
        question.heights[1] = most
    if question.arm and question.offsets[0] is None and most is not None:
        question.offsets = [-most, most]
    if question.swung and most is not None and question.empty(question.highest(question.aim)):
        return
    for found in body.get("rounds", ()):  # bounds that follow from those of the rounds before
        narrow(question, [bound_of(question, step) for step in found])
    if "cases" not in body:
        question.radii = small, radius if question.aim is None else question.aim
        excess = least(question, get(body, "multipliers", dict))
        demand(excess > 0, "the multipliers do not exclude every size")
        return
    cases, value = get(body, "cases", list), get(body, "value")  # of e or s0: below it and above
    demand(len(cases) == 2, "there are not two cases", 2)
    names = "offset", "s0", *(("arm",) if question.arm else ())
    which = names.index(get(body, "of", str))
    for k, case in enumerate(cases):
        part = copy(question)
        part.bent = {}
        spend("coefficients", len(question.known))
        for name in ("offsets", "heights", "arms", "known"):
            setattr(part, name, deepcopy(getattr(question, name)))
        (part.offsets, part.heights, part.arms)[which][1 - k] = value
        exclude(part, case)

def bound_of(question, step):
    """The bounds of what a step speaks of, which of them it gives, and what."""
    k, proof = whole(step, "bound", 0, 3), get(step, "multipliers", dict)
    way = (1, -1)[k % 2]
    if step.get("segment") is None:  # of e or s0, from below or from above
        bound = least(question, proof, (None, ZERO, [], [way * (k < 2), way * (k > 1)]))
        ends = (question.offsets, question.heights)[k // 2]
        return ends, k % 2, min(bound / c for c in question.unit) if k < 2 else bound
    # X or U at a place
    index, x = whole(step, "segment", 0, len(question.program) - 1), get(step, "x")
    alpha, size = [way * (k < 2), way * (k > 1), 0], [-way * (k > 1), way * (k < 2)]
    if question.arm:  # of an arm s alone
        demand(k < 2, "of an arm only its swing is bounded")
        size = [ZERO] * 2
    bound = least(question, proof, (question.program[index], x, alpha, size))
    return question.known.setdefault((index, x), [None] * 4), k, floor(bound)

# Step 8. The claims: what the question asks for, each proven or said not to be covered.
def places(asked, cam):
    found = [f"objective/{k}" for k in range(len(aims_of(asked)))]
    found += [f"limits/{k}" for k in range(len(get(asked, "limits", list)))]
    found += ["no_undercut", "self_crossing", "motion", "size"]
    found += [f"program/{k}/{name}" for k, segment in enumerate(get(asked, "program", list))
              for name in ("windows", "points", "start", "end") if segment.get(name)]
    return ["infeasible"] if cam is None else found

def excluded(asked, place, claim, body):
    """Check a claim about all cams, and say it."""
    question, text = Question(asked), "no law and no size keep these limits together"
    if place != "infeasible":
        aims, value = aims_of(asked), get(claim, "at_least")
        held = numbers(claim.get("held", []))
        demand(f"objective/{len(held)}" == place, "not all objectives before it are held", 2)
        named = hold(question, aims, held)
        if held:  # what the cam of the file keeps as well
            cam = Cam(Question(asked, body.get("program", ())), body)
            hold(cam.question, aims, held)
            for each in ("size", *(x for x in cam.question.limits if x[:5] == "held/")):
                cam.check(each)
        aim = kind_of(aims[len(held)], *AIMS)
        if aim == "base_radius":
            # rounds speak of all cams below another radius, which is no smaller
            below = get(claim, "below") if "rounds" in claim or "cases" in claim else value
            demand(below >= value >= 0, "rounds do not speak of all cams")
            question.aim, question.radii[1] = map(question.smaller, (value, below))
        else:
            impose(question, aims[len(held)], value, "objective")
        kept = " and ".join(f"{kind} up to {decimal(most)}" for kind, most in zip(named, held))
        kept = f" with {kept}, as this one," if held else ""
        article = "an" if aim in SQUARES else "a"
        text = f"no cam of this question{kept} has {article} {aim} below {decimal(value)}"
        if aim == "base_radius" and value <= (range_of(asked["base_radius_mm"])[0] or 0):
            return text  # no smaller one is asked for
    exclude(question, claim)
    return text

def aims_of(asked):
    return asked["objective"] if isinstance(asked["objective"], list) else [asked["objective"]]

def hold(question, aims, held):
    """Impose what objectives before another may come to; their kinds."""
    return [impose(question, aim, value, f"held/{k}")
            for k, (aim, value) in enumerate(zip(aims, held))]

def impose(question, aim, value, name):
    """A largest value of an objective is a limit like others; its kind."""
    kind = kind_of(aim, *AIMS)
    demand(value >= 0, "an objective is negative")
    if kind == "base_radius":
        question.radii[1] = question.smaller(value)
    elif kind == "peak_pressure_angle":
        demand(not question.face, "it has no pressure angle")
        question.limits[name] = {"kind": kind[5:], "rise_deg": value, "return_deg": value,
                                 "dwell_deg": None}
    elif kind in SQUARES:
        question.limits[name] = {"kind": kind, "most": value}
    else:
        question.limits[name] = {"kind": kind[5:], FIELDS[kind[5:]]: value}
    return kind

def check(content):
    """The exit code, after a sentence for each claim."""
    at = "the file"
    circle.cache_clear()
    try:
        proof = read(content)
        good = get(proof, "format", str) == "camwright-proof" and get(proof, "version") == 1
        demand(good, "it is not a proof of version 1", 2)
        asked, body, claims, cam = proof["question"], proof["cam"], proof["claims"], None
        named, wanted = [get(claim, "place", str) for claim in claims], places(asked, body)
        demand(sorted(named) == sorted(wanted), f"its claims are not {', '.join(wanted)[:300]}")
        for at, claim in zip(named, claims):
            if not get(claim, "proven", bool):
                demand(get(claim, "reason", str), "it is not proven, and no reason is given", 2)
                text = f"not covered: {ascii(claim['reason'])[:100]}"
            elif at == "infeasible" or at[:10] == "objective/":
                text = excluded(asked, at, claim, body)
            else:
                cam = cam or Cam(Question(asked, body.get("program", ())), body)
                text = cam.check(at)
            print(f"{at}: {text}")
        print(f"{sum(claim['proven'] for claim in claims)} of {len(claims)} claims proven")
    except Failure as failure:
        print(f"{at}: {failure.args[0]}")
        return 2 if len(failure.args) > 1 else 1
    except (ValueError, RecursionError, LookupError, AttributeError, TypeError, ArithmeticError,
            MemoryError) as error:
        print(f"{at} cannot be read: {type(error).__name__} {ascii(str(error))[:100]}")
        return 2
    return 0

def contents(path):
    """The name and the content of a file, or of every file in an archive."""
    if not path.endswith(".zip"):
        with open(path, "rb") as file:
            yield path, file.read(MOST_BYTES + 1)
        return
    with ZipFile(path) as archive:
        files = archive.infolist()
        demand(0 < len(files) <= MOST_FILES, "the archive holds no files, or too many")
        for each in files:
            demand(each.compress_type in (0, 8), "neither stored nor deflated")
            with archive.open(each) as file:
                yield f"{path}/{each.filename}", file.read(MOST_BYTES + 1)

if __name__ == "__main__":
    code = 0 if sys.argv[1:] else 2
    for path in sys.argv[1:]:
        try:
            for name, content in contents(path):
                spent.clear()
                print(ascii(name)[1:-1])
                code = max(code, check(content))
        except Exception as error:  # of the disk, or whatever damage zipfile meets
            print(f"{ascii(path)[1:-1]} cannot be read: {ascii(str(error))[:100]}")
            code = 2
    sys.exit(code)
