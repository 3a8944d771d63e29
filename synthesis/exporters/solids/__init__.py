"""The cam as a solid body with bore, keyway, hub and groove.

In: a design and ``SolidOptions``. Out: a STEP file. ``blank`` plans the slabs and their volumes;
``body`` has OpenCASCADE make them, cut and unite them. Open ``blank`` first.
"""
