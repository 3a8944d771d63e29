"""Parameters: numbers that a spec leaves free around its motion laws.

``search.py`` chooses angles, lifts and an arm's length: ``number_search`` bounds all of them,
``longer_moves`` where curvature decides, and ``merged_moves`` makes one move of several.
``spring_design.py`` chooses a spring, ``table_smoothing.py`` the splines of tabulated motion. Each
asks the driver, or a whole design, for the value at the parameters that it tries.
"""
