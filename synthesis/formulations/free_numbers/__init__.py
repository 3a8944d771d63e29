"""Numbers left open around the program: angles, lifts, lengths, a spring, tables to smooth.

The searches over them stand above the ladder and climb it for the values that they try.
"""
