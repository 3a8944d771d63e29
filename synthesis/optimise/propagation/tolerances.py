"""Numeric allowances of bound tightening."""

LOOSENING = 1e-9
"""Relative, by which every bound is loosened. Dual bounds allow for their own rounding, of about
1e-12; this covers the arithmetic that is done with them, and sizes known this well count as known.
"""
