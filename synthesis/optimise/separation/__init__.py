"""Separation: cuts that a relaxation's solution violates.

``outer_approximation.py`` linearises curved limits at the last solution until the rows touch them.
"""
