"""Tables of numbers: CSV, JSON and plain text, of profiles, motions and responses.

In: columns (``samples.columns``). Out: bytes; numbers are the shortest that read back to the same
double. Open ``formats`` first; ``shortest`` writes whole columns of numbers at once.
"""
