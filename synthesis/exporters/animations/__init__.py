"""The machine in motion: as SVG, as a page, as data.

In: a design or any answer with a scene. Out: a file. ``scene`` is what every animation shows, a
machine beside diagrams, and writes it as SVG and as a page; ``cam_animation`` has the scene of a
cam and its formats. Open ``scene`` first.
"""
