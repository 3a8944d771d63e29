"""Drawings of the cam and its follower, in the cam's mm, y upwards.

In: a design. Out: SVG elements. ``profile`` is the drawing of the cam at cam angle 0; ``machine``
draws the machine in parts that can be moved, whose positions over a turn are in ``mechanism``.
``parts`` is what both share.
"""
