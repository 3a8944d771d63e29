"""Plane curves on a turning disc; they know neither limits nor the wire."""
