"""Diagrams over the cam angle, or the shaft's, as SVG in mm.

In: a design, a cam set or a sweep's front. Out: a sheet. ``plot`` says what one diagram shows
(curve, limits, numbers at the axis) and draws it; ``sheet`` stacks several under the strip of
segments, and makes the sheets of a design's motion and contact. ``timing`` and ``tradeoff`` are
drawings of their own. Open ``plot`` first.
"""
