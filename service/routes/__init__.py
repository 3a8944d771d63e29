"""Paths and handlers.

`resource_routes.py` makes the routes of any kept resource and of its files; the other modules hold
what one resource alone has. Begin with `resource_routes.py`.
"""
