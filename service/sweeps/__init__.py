"""Sweeps: many designs from one base spec.

In comes a `SweepSpec`; out come its items, each a design, as pages, events, tables and a Pareto
front. `sweeps.Sweeps` accepts, continues and stops sweeps; a `runner.SweepRunner` runs one:
`chunks` chooses the items that go to the workers next, `tasks` is what a worker does, `store` keeps
the finished items. `lease` lets one process of several that share the database work on a sweep, and
another one continue it when that process dies. `views`, `table` and `pareto` are what comes out.
Begin with `runner.py`.
"""
