"""Sweeps: many designs from one base spec.

In comes a `SweepSpec`; out come its items, each a design, as pages, events, tables and a Pareto
front. `sweeps.Sweeps` accepts, continues and stops sweeps, and a `SweepRunner` there runs one:
`chunks` chooses the items that go to the workers next, `tasks` is what a worker does, `store` keeps
the finished items, and leases, so that one process of several that share the database works on a
sweep and another one continues it when that process dies. `views` is what comes out. Begin with
`sweeps.py`.
"""
