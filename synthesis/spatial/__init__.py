"""Spatial cams: rollers on axes that do not lie along the cam's."""
