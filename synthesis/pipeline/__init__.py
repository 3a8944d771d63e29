"""Pipeline: from a specification to a certified design.

In: a ``DesignSpec``. Out: a ``Design``. ``synthesise.py`` is the whole way on one page;
``assembly.py`` writes the design in the units of the wire. The optimiser proposes, the
certificate decides.
"""
