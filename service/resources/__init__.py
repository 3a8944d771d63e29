"""What is kept by id: a table each, the work under way for it, and how it looks on the wire.

One code for all: the routes of a resource say only what is its own.
"""
