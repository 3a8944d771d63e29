"""What CAD systems and controls make of a curve's written points, and what that does to a follower.

In: a cam's curve and the points of it as a file holds them. Out: for every way of interpolation the
greatest deviation of form, velocity and acceleration, as JSON or as a line for a header. Open
``measure`` first: interpolants, the kinematics of a follower on a curve known by its points,
tangents and curvatures, and deviations; ``report`` has words and formats.
"""
