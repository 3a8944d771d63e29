"""Spatial cams: rollers whose axes are not parallel to the cam's (globoidal and cylindrical cams).

In: a SpatialCamSpec. Out: a SpatialDesign and its files. Open ``pipeline`` first. ``spec``, with
its limits, and ``design`` are the request and response; ``machine`` is what every machine provides,
with those machines in ``globoidal_indexer`` and ``cylindrical``. Sizing (``sizing``) chooses laws
and dimensions under limits, whose nonlinear ones are ``size_constraints``; ``measuring`` judges the
cam. ``cam`` holds its walls, the envelopes of the rollers; ``grooves``, ``body`` and
``solid`` make bodies of them, ``files`` writes them.
"""
