"""Catalogue: what a cam mechanism can be made of; a new thing is a class and its name in a list.

    laws        normalised motion laws g(x)             limits      quantities that have a bound
    followers   mechanisms, their kinematics and size   objectives  quantities that are minimised
    forces      loads, springs, friction, contact

Each has a registry (``AnyLaw``, ``AnyLimit``, …), and conformance tests that run over it. What goes
in are parts of a spec, as pydantic models; what comes out are the constraints of the optimiser, the
bounds that the certificate has to show, and formulas for numbers, symbols and enclosures alike.
``constraints`` holds the kinds of constraints, ``motion`` the displacement over one turn,
``profile`` the cam's curves. Open ``constraints`` first.
"""
