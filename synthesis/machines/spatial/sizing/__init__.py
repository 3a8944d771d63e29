"""Sizing: motion laws, rollers and the minimised dimension of a spatial cam, with a lower bound.

In: a SpatialCamSpec that leaves laws or dimensions free. Out: a ``SizingResult`` with laws, sizes
and a bound that no cam of the spec is below. Open ``size_cam`` first: it lists the steps, and
enlarges the cam until sampled walls and ribs are sound. ``sequential_convex`` presents the machine
to the optimiser of ``synthesis.optimise`` and minimises the size under pressure-angle limits that
are not convex; ``phase_plane`` bounds it over all laws; ``infeasibility`` says which single number
would have to change where nothing fits.
"""
