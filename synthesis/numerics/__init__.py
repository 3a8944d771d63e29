"""Splines, peaks, enclosures: numerics that know neither cams nor the wire."""
