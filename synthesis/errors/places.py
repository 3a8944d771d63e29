"""Where in a request the caller is pointed to by rules over several of its fields."""

from __future__ import annotations

# Rules over several fields, by the place in the spec that the caller is pointed to. The spec may be
# part of a set. Names in braces are in the error's context.
PLACES = {
    kind: tuple(place.split("/"))
    for place, kinds in {
        "program": (
            "program_angles program_lift program_still numbers_do_not_fit swing_too_large "
            "face_turns_with_cam index_not_whole"
        ),
        "program/{segment}/{name}": "one_number_free",
        "program/{segment}/{end}": "states_differ state_not_met",
        "program/{segment}": (
            "state_not_neighbours state_backwards acceleration_alone law_backwards"
        ),
        "base_radius_mm": "base_radius_positive roller_fills_ring base_radius_inside_hub",
        "shaft_diameter_mm": "keyway_without_shaft keyway_has_no_standard ring_has_no_hub",
        "hub_diameter_mm": "hub_too_small",
        "follower/offset_mm": "offset_beyond_prime_radius",
        "program/{position}": "lift_does_not_suit",
        "limits/{position}": (
            "limit_unit_does_not_suit crown_leans limit_needs_load limit_needs_contact "
            "edge_has_no_pressure"
        ),
        "follower/centre_distance_mm": "centre_distance_positive face_swings_too_far",
        "follower": "arm_does_not_reach",
        "follower/arm_mm": "roller_on_pivot",
        "follower/{name}": "no_length_serves",
        "follower/initial_angle_deg": "initial_angle_range initial_angle_contradicts",
        "objective": (
            "no_best_pressure_angle pressure_angle_given objective_does_not_suit "
            "objective_needs_load process_not_steady"
        ),
        "limits": (
            "no_smallest_cam limit_does_not_suit nothing_keeps_large outer_radius_too_small "
            "vibration_too_far_off no_dwell_to_ring_in"
        ),
        "program/{position}/law": "spline_too_rough",
        "machine/{name}": "no_such_size",
        "machine": "machine_in_full rollers_vanish roller_beside_cylinder",
        "machine/roller_radius_mm": "rollers_overlap",
        "machine/centre_distance_mm": "grooves_reach_axis",
        "cams/{position}/spec/{field}": "cam_off_the_shaft",
        "axes/{position}/{name}": "axis_leads_nowhere axes_share_a_field balance_needs_numbers",
        "axes/{position}": "axis_without_count axes_of_unequal_length",
        "{name}": "wish_missing",
        "acceleration_rad_per_s2": "sized_at_constant_speed",
        "follower/roller_radius_mm": "groove_needs_roller",
        "follower/closure/rim_mm": "rim_without_ring",
        "load/kind": "load_does_not_suit",
        "load": "nothing_presses_follower",
        "load/friction": "friction_does_not_suit friction_needs_sense",
        "load/friction/overhang_mm": "overhang_too_short",
        "limits/{position}/min_n": "never_floats",
        "train/masses": "train_not_held train_grows",
        "speeds_rpm/{position}": "train_resonates",
        "machine/crown_radius_mm": "crown_too_round",
        "machine/roller_width_mm": "roller_reaches_axis",
        "machine/roller_distance_mm": "rollers_touch",
        "machine/initial_angle_deg": "arm_along_cam",
    }.items()
    for kind in kinds.split()
}
