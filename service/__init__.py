"""The web service of Camwright: it validates, dispatches and stores; the core computes.

    app, server, settings, state   the running application and its configuration
    routes/      paths and handlers          resources/   what is kept by id, one record each
    sweeps/      many designs from one spec  storage/     the database
    workers/     processes that compute      wire/        bodies, errors, tags, ranges, metrics
    contract/    the OpenAPI document        pages        the studio, the guide, /docs
    client/      for programs                commands/    for the command line

A question goes from `routes/resource_routes.py` over `resources/jobs.py` and `workers/engine.py` to
`workers/tasks.py`, which calls the core. Begin with `app.py`.
"""
