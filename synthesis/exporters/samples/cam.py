"""The finished cam as a file sees it: evaluated anywhere, with the places where its parts meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

from synthesis.catalogue.fields import Rotation
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.followers.flank import Flank, labelled
from synthesis.catalogue.profile import CamProfile, cam_profile
from synthesis.design.design import Design
from synthesis.errors import InputError
from synthesis.exporters.options import CURVES, CurveName, PlacedCurve, is_pitch
from synthesis.exporters.samples.turn import Mask, Turn
from synthesis.numerics.piecewise import Array, Side
from synthesis.units import rad_per_s


@dataclass(frozen=True, eq=False)
class Cam(Turn):
    """A design's cam and one of its curves.

    Attributes:
        flank: the flank that the curve is, or belongs to.
        gap: of the curve inwards from the traced one, along its outward normal [mm]: σD of the
            flank itself, 0 of the pitch curve, σ(D − Rc) of the path of a cutter of radius Rc.
        the rest as of ``Turn`` and in ``cam_profile``.
    """

    follower: Follower
    size: tuple[float, ...]
    rotation: Rotation
    flank: Flank
    gap: float

    @classmethod
    def of(cls, design: Design, options: PlacedCurve | None = None) -> Cam:
        """The cam of a design and the curve that is asked for, its first profile unless said.

        A given cam that breaks its limits is infeasible, and yet can be drawn.

        Raises:
            InputError: the design found no cam, or its cam has no such curve.
        """
        if not design.motion:
            raise InputError(
                "/status",
                design.status,
                "A design that found no cam has no profile and no motion.",
                "Make the least change that its field `conflict` names, and ask again.",
            )
        follower = design.completed_spec.follower
        flank = _flank(follower, options.curve if options else "profile")
        return cls(
            design.curve, follower.travel, rad_per_s(design.speed_rpm), follower,
            tuple(design.size), design.rotation, flank, _gap(flank, options),
        )  # fmt: skip

    def flanks(self) -> Iterator[Cam]:
        """The same cam once for each of its flanks."""
        for flank in self.follower.flanks:
            yield replace(self, flank=flank, gap=_gap(flank, None))

    def at(self, theta: Array, left: Mask | None = None) -> CamProfile:
        """The cam at θ (n,) [rad]; where ``left`` (n,) holds, the limits from the left."""
        at = self._one_sided(theta, "right")
        if left is not None and left.any():
            before = self._one_sided(theta[left], "left")
            for field in fields(CamProfile):
                if field.name != "theta":
                    getattr(at, field.name)[..., left] = getattr(before, field.name)
        return at

    def place(self, at: CamProfile) -> tuple[Array, Array]:
        """x and y of the curve [mm], in the cam's frame."""
        return at.pitch_x - self.gap * at.normal_x, at.pitch_y - self.gap * at.normal_y

    def _one_sided(self, theta: Array, side: Side) -> CamProfile:
        return cam_profile(
            self.motion, self.follower, self.size, self.rotation, theta, side, self.flank
        )


def profiles(design: Design) -> dict[str, CurveName]:
    """Every flank of a design's cam as a curve, by the stem of its file: profile, profile-outer."""
    further = {flank.name for flank in design.completed_spec.follower.flanks[1:]}
    curves: dict[str, CurveName] = {"profile": "profile"}
    return curves | {f"profile-{each}": each for each in CURVES if each in further}


def _flank(follower: Follower, curve: CurveName) -> Flank:
    """The flank that a curve is of; InputError where the cam has none of this name."""
    first, *others = follower.flanks
    counter_paths = follower.active_closure.counter_paths
    curves = {"profile": first, "pitch": first}
    curves |= {flank.name: flank for flank in follower.flanks if flank.name}
    curves |= {labelled(each.path, "pitch"): each for each in others if each.path in counter_paths}
    curves |= {"cutter": first, **{f"{flank.name}_cutter": flank for flank in others}}
    if curve in curves:
        return curves[curve]
    raise InputError(
        "/curve", curve, f"This cam has no such curve. Its curves are {', '.join(curves)}.",
        "Choose one of these.",
    )  # fmt: skip


def _gap(flank: Flank, options: PlacedCurve | None) -> float:
    """See ``Cam.gap``."""
    if options is not None and is_pitch(options.curve):
        return 0.0
    diameter = options.cutter_diameter_mm if options is not None else None  # of cutters only
    return flank.side * (flank.distance - 0.5 * (diameter or 0.0))
