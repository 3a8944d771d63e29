"""Machines other than the planar cam: spatial cams, linkages, and follower trains.

Each has its own spec, answer and files, and uses catalogue, numerics and optimise.
``spatial`` sizes and measures globoidal and cylindrical cams; ``linkages`` analyses and sizes
mechanisms of rigid links; ``dynamics`` computes the vibration of an elastic train on a cam.
"""
