"""Pipeline: from a specification to a certified design.

In: a ``DesignSpec``. Out: a ``Design``. ``synthesise.py`` is the whole way on one page;
``largest_radius.py`` says in which order questions are put to the optimiser, ``attempt.py`` solves
and certifies one (``goal.py``: until when), ``radius_search.py`` makes a cam larger or smaller
where that needs trials, ``infeasibility.py`` has the proofs that no cam fits, ``conflict.py`` finds
out why nothing fits by asking changed questions (``oracle.py``), ``boundary.py`` how far each
number would have to be relaxed, and ``assembly.py`` writes the design in the units of the wire. The
optimiser proposes, the certificate decides.
"""
