"""The machine in motion: as SVG, as a page, as data.

In: a design or any answer with a scene. Out: a file. ``scene`` is what every animation shows, a
machine beside diagrams; ``cam_scene`` is that of a cam; ``animation_svg`` and ``animation_page``
write a scene; ``formats`` makes the files. Open ``scene`` first.
"""
