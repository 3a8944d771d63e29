"""What is kept by id: questions with their answers.

In comes a question, a model of the core; out goes its answer, a row of the store with the bytes of
the response. A resource is one record (`resource.Resource`): its path, the models of question and
answer, the task that a worker runs, the lines of lists, its files. `records` holds them all, by
path in `RESOURCES`. `jobs.Jobs` runs the questions of one resource, shares work on the same
question and keeps the answers; `routes/resource_routes.py` makes the routes of any. A new kind of
question is a record and a task in `workers/tasks.py`. Begin with `records.py`.
"""
