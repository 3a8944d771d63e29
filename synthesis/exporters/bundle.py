"""All files of a set in one ZIP archive. The same set and options give the same bytes.

    manifest.json               what is in it, with SHA-256, and how the cams sit on the shaft
    cam-set.json                the set as delivered
    timing.svg, timing.csv      what happens when
    01-inlet/design.json        the first cam as designed
    01-inlet/profile.*          its profile in its own frame
    01-inlet/shaft-profile.*    its profile in the shaft's frame: turned, and at its place along it
    01-inlet/motion.*           its motion over its own cam angle

A cam of several flanks has a file for each: profile.* is the first, then profile-outer.* or
profile-counter.*; rollers' paths are called pitch.*. Drawings show a cam in its own frame only,
and all of it. A cam for which nothing fits has its design.json alone.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, cast
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from synthesis.catalogue.followers.kinematics import labelled
from synthesis.design.cam_set import CamSet, MountedCam
from synthesis.errors import InputError
from synthesis.exporters import MOTION_FORMATS, PROFILE_FORMATS
from synthesis.exporters.diagrams.timing import timing_diagram
from synthesis.exporters.options import CurveName, MotionOptions, ProfileOptions
from synthesis.exporters.samples.cam import profiles

LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the earliest time that ZIP can hold; no clock in the bytes
LEVEL = 2  # of DEFLATE: fast
PLAIN_FILE = 0o100644 << 16  # POSIX mode 0100644 in the upper half of the ZIP attribute
UNIX = 3  # "made by" of a ZIP entry
WHICH: tuple[CurveName, ...] = ("profile", "pitch")
MEDIA_TYPE = "application/zip"
CONVENTIONS = (
    "Right-handed frames, z along the shaft; lengths in mm, angles in degrees, counter-clockwise "
    "positive seen with z towards the viewer. The shaft's frame turns with the shaft and is the "
    "machine's at shaft angle 0. In it a cam is its own design turned by turn_deg = "
    "follower_direction_deg - 90 - phase_deg (ccw shaft) or + phase_deg (cw shaft). At shaft angle "
    "T its follower stands where the design alone has it at cam angle T - phase_deg."
)


@dataclass(frozen=True)
class BundleOptions:
    """What goes into an archive: names from the registries, in any order, and how they sample.

    ``profile`` also says whether curves are profiles or pitch curves; which ones a cam has, and
    their place on the shaft, is the set's own business.
    """

    profile_formats: tuple[str, ...] = ("csv", "txt")
    motion_formats: tuple[str, ...] = ("csv",)
    profile: ProfileOptions = field(default_factory=ProfileOptions)
    motion: MotionOptions = field(default_factory=MotionOptions)

    def __post_init__(self) -> None:
        if self.profile.curve not in WHICH:
            rule = f"Of a set these can be had: {', '.join(WHICH)}."
            remedy = "Name one of them: every cam gives all that it has of it."
            raise InputError("/curve", self.profile.curve, rule, remedy)
        requested = {"/profile": self.profile_formats, "/motion": self.motion_formats}
        for pointer, known in (("/profile", PROFILE_FORMATS), ("/motion", MOTION_FORMATS)):
            unknown = [name for name in requested[pointer] if name not in known]
            if unknown:
                rule = f"The formats here are {', '.join(known)}."
                raise InputError(pointer, unknown[0], rule, "Name some of them.")


def bundle(cams: CamSet, options: BundleOptions) -> bytes:
    """The archive."""
    return archive(bundle_files(cams, options))


def archive(files: Iterable[tuple[str, bytes]]) -> bytes:
    """A ZIP archive of names and contents: the same files give the same bytes."""
    packed = io.BytesIO()
    with ZipFile(packed, "w") as zipped:
        for name, content in files:
            entry = ZipInfo(name, LONG_AGO)
            entry.compress_type, entry.create_system = ZIP_DEFLATED, UNIX
            entry.external_attr = PLAIN_FILE
            zipped.writestr(entry, content, compresslevel=LEVEL)
    return packed.getvalue()


def bundle_files(cams: CamSet, options: BundleOptions) -> Iterator[tuple[str, bytes]]:
    """Names and contents one by one, the manifest last; InputError where no cam fits."""
    if not cams.has_cams:
        rule = "No cam of this set fits its limits, so there is nothing to write."
        remedy = "Take a value of `needed` from the field `conflict` of the design, and ask again."
        raise InputError("/status", cams.status, rule, remedy)
    listed = []
    for name, content in _contents(cams, options):
        digest = hashlib.sha256(content).hexdigest()
        listed.append({"name": name, "bytes": len(content), "sha256": digest})
        yield name, content
    yield "manifest.json", _manifest(cams, options, listed)


def folders(cams: CamSet) -> list[str]:
    """A folder for each cam: its number and its name, in letters that every system takes."""
    digits, names = max(2, len(str(len(cams.cams)))), []
    for i, cam in enumerate(cams.cams, start=1):
        ascii_only = unicodedata.normalize("NFKD", cam.name).encode("ascii", "ignore").decode()
        plain = re.sub(r"[^A-Za-z0-9]+", "-", ascii_only).strip("-")[:40].rstrip("-") or "cam"
        names.append(f"{i:0{digits}d}-{plain}")
    return names


def _contents(cams: CamSet, options: BundleOptions) -> Iterator[tuple[str, bytes]]:
    yield "cam-set.json", cams.model_dump_json(indent=1).encode()
    yield "timing.svg", timing_diagram(cams)
    yield "timing.csv", timing_table(cams)
    for folder, cam in zip(folders(cams), cams.cams, strict=True):
        for name, content in _files_of(cam, options):
            yield f"{folder}/{name}", content


def _files_of(cam: MountedCam, options: BundleOptions) -> Iterator[tuple[str, bytes]]:
    design = cam.design
    yield "design.json", design.model_dump_json(indent=1).encode()
    if not cam.has_cam:
        return
    curves = _curves(cam, options.profile.curve)
    # in the order of the registries, whatever that of the names
    for name, profile in PROFILE_FORMATS.items():
        if name not in options.profile_formats:
            continue
        if not profile.placeable:
            yield f"profile{profile.extension}", profile.write_like(design, options.profile)
            continue
        for stem, curve in curves.items():
            own = replace(options.profile, curve=curve)
            on_shaft = replace(own, turn_deg=cam.turn_deg, z_mm=cam.axial_mm)
            file = f"{stem}{profile.extension}"
            yield file, profile.write_like(design, own)
            yield f"shaft-{file}", profile.write_like(design, on_shaft)
    for name, motion in MOTION_FORMATS.items():
        if name in options.motion_formats:
            yield f"motion{motion.extension}", motion.write_like(design, options.motion)


def _curves(cam: MountedCam, curve: CurveName) -> dict[str, CurveName]:
    """The curves that a cam consists of, by what their files are called."""
    if curve == "profile":
        return profiles(cam.design)
    companions = cam.design.completed_spec.follower.closure.counter_paths
    others = [cast(CurveName, labelled(path, "pitch")) for path in companions]
    return {name.replace("_", "-"): name for name in (curve, *others)}


def timing_table(cams: CamSet) -> bytes:
    """The events as CSV, in the order of shaft angle."""
    lines = ["shaft_deg,cam,folder,ends,starts"]
    named = folders(cams)
    lines += [
        f"{event.shaft_deg!r},{event.cam + 1},{named[event.cam]},{event.ends},{event.starts}"
        for event in cams.timing.events
    ]
    return ("\n".join(lines) + "\n").encode()


def _manifest(cams: CamSet, options: BundleOptions, listed: list[dict[str, Any]]) -> bytes:
    placed = [
        {
            "folder": folder,
            "design": cam.design.id,
            "status": cam.design.status,
            "severity": cam.design.severity,
        }
        | cam.model_dump(mode="json", exclude={"design"})
        for folder, cam in zip(folders(cams), cams.cams, strict=True)
    ]
    names = ("id", "name", "engine_version", "status", "severity", "rotation", "speed_rpm")
    body = {name: getattr(cams, name) for name in names} | {
        "conventions": CONVENTIONS,
        "sampling": {
            "curve": options.profile.curve,
            "points_per_degree": options.profile.points_per_degree,
            "tolerance_um": options.profile.tolerance_um,
            "motion_points_per_degree": options.motion.points_per_degree,
        },
        "cams": placed,
        "files": listed,
    }
    return json.dumps(body, ensure_ascii=False, indent=1).encode() + b"\n"
