"""Specification: what is asked, as it comes over the wire, checked and placed on the cam.

What goes in is JSON: a ``DesignSpec`` (one cam) or a ``CamSetSpec`` (several on one shaft); names
of fields end with their unit. What comes out are the program's segments placed on the cam, the
limits that hold on them, the machine around the cam, and the numbers that are left free. A spec
that contradicts itself is refused with the wrong value, the rule and the way out.

    design_spec               one question; open it first
    program, segment, table   segments of the motion; ``motion_constraints``: windows and points
    schedule                  segments side by side, with the states at their junctions
    free_parameters           angles, lifts and lengths that an outer search chooses
    well_posedness            questions that have no best answer
"""
