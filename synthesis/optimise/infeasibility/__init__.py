"""Infeasibility: an irreducible set of limits that cannot hold together, and what would help.

In: a problem without a cam. Out: a ``Conflict``. Open ``diagnosis.py``: elastic programs over
relaxable limits and a deletion filter (Chinneck); ``diagnosis_by_search.py`` where limits are
curved and whole solves are the oracle.
"""
