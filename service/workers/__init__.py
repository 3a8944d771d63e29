"""Where solves run: the engine in the service, and what its workers do with the bytes they get.

Dask is known in this room only.
"""
