"""The cam as every file sees it: at which angles, where its points stand, in which columns.

In: a design and options. Out: cam angles, points, columns. ``cam`` is a motion over one turn with
the places where its pieces meet, and a design's cam with one of its curves, evaluated anywhere;
``sampling`` the rows of tables and the rings of points, evenly or for a chord tolerance;
``cutting`` checks cutters; ``columns`` names what tables hold. Open ``cam`` first.
"""
