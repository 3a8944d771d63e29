"""Programs for machine tools: paths of cutters and wheels with a feed (ISO 6983, "G-code").

In: a design, ``PointOptions``, a feed. Out: blocks of text. ``program`` has the path of the tool's
centre, its time and the words of a block; ``milling`` runs it in X and Y, ``grinding`` turns the
cam and shifts the wheel.
"""
