"""Sweeps: many designs from one base spec.

`sweeps.Sweeps` accepts, continues and stops them; a `runner.SweepRunner` runs one: `chunks` chooses
the items that go to the workers next, `tasks` is what a worker does, `store` keeps the items,
`lease` lets one process of several work on a sweep. `views`, `table` and `pareto` are what comes
out. Begin with `runner.py`.
"""
