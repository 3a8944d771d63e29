"""Solid: the boundary representation of a cam's body, with true surfaces and B-spline walls.

In: the sections of a cam's grooves (``grooves.GrooveSections``), its blank, and a tolerance. Out: a
closed ``Shell`` of faces, edges and vertices, which ``files.step`` writes. Open ``build``
first. ``sheets`` says where walls lie and where they leave the blank, and fits them by B-splines;
``geometry`` holds curves, surfaces and the shell.
"""
