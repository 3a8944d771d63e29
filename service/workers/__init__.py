"""Worker processes: the engine that the service sends tasks to, and the tasks.

Bytes of a question go in, bytes of an answer come out (`tasks`). `engine` lets no more tasks run
than there are workers, and cancels what overruns its time; `local` has worker processes at the ends
of pipes and replaces those that die, `remote` those of a Dask scheduler elsewhere, which
`scheduler` starts. Workers are forked from a process that has imported the core (`prefork`,
`preload`); so are `readers`, which read long bodies. Dask is used in this package only. Begin with
`tasks.py`, then `engine.py`.
"""
