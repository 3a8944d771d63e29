"""Points for the curve import of CAD systems."""
