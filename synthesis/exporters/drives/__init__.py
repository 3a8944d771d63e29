"""Tables of the follower's motion for servo drives that take its place: electronic cams.

A format a file; of a controller's layout only what its maker documents.
"""
