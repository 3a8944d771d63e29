"""Measuring: every quantity of a finished spatial cam, its extreme, where and how it is known.

In: a SpatialCam and its spec. Out: a ``SpatialExtreme`` for each quantity; the cam is accepted
where all of them hold. Open ``measure`` first: it lists the quantities, compares all with their
bounds, and measures the motion, the windows and points of the program, and contacts and ribs by
samples on ``patches`` of walls. ``enclosure`` proves what was found for cylindrical rollers, by
branch and bound with Taylor models.
"""
