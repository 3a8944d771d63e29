"""The question in numbers: laws free or given, the grid they bend and are watched on, their ends.

Everything else in the formulations is said in these terms.
"""
