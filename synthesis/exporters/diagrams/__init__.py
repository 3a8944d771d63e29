"""Diagrams: quantities over the cam angle, timing of a set, trade-offs of a sweep."""
