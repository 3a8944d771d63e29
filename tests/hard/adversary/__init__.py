"""Another optimiser, which tries to beat every bound and to satisfy what is called infeasible.

Motions are constant jerks in turns, limits are textbook formulas on samples, and the search is
sequential linear programming with an exact penalty from random starts. Nothing of the product is
imported; what it finds is measured by the verifier of this directory.
"""
