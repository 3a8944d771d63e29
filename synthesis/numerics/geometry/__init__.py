"""Geometry that knows neither limits nor the wire: curves on a turning disc, rollers in space.

``closed_curve.py`` says what a closed plane curve is and divides it into pieces;
``closed_spline.py`` and ``biarcs.py`` approximate it within a tolerance, by a B-spline or by arcs.
``swept_roller.py`` has the walls that a roller leaves on a spatial cam, ``charts.py`` the
coordinates of its blank, ``plane.py`` the frames of a disc cam.
"""
