"""Parameters: numbers that a spec leaves free around its motion laws.

``search.py`` chooses angles, lifts and an arm's length, ``spring_design.py`` a spring,
``table_smoothing.py`` the splines of tabulated motion. Each asks the driver, or a whole design, for
the value at the parameters that it tries.
"""
