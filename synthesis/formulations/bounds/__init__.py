"""Lower bounds over every motion law there is, from the multipliers of a cone program.

By duality: whatever multipliers a solver returns, what is made of them here is a bound.
"""
