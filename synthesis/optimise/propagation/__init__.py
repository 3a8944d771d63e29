"""Propagation: bounds on size and motion that every cam better than the incumbent satisfies.

In: a cone model whose objective is replaced by a cap on its value. Out: tighter bounds of the
sizes, of the laws and of the traced point, each from dual multipliers, so valid over all laws.

Open ``bound_tightening.py`` first. ``law_tightening`` bounds laws and sizes one by one;
``quantity_bounds`` has the programs and the bounds of both.
"""
