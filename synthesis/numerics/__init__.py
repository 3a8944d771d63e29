"""Numerics that know neither cams nor the wire: splines, peaks, proven extremes, solvers.

In: plain functions and arrays. Out: numbers, and where a proof needs them intervals that hold the
exact value, roundings included. Open ``piecewise.py`` first: polynomials and sinusoids piece by
piece, the form of every motion law. ``bspline.py`` makes them from coefficients, ``maxima.py`` has
their peaks in floating point. A proven extreme goes through ``taylor.py`` (Taylor models of such a
function, and their arithmetic), ``enclosure.py`` (branch and bound over boxes) and
``box_search.py``, the one loop behind it, which other searches use as well. ``polytope.py``
minimises functions with kinks over a part of the unit box; ``geometry`` has plane curves and
rollers, ``solvers`` the adapters to Clarabel, HiGHS and IPOPT.
"""
