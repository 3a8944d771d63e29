"""What is kept by id: questions with their answers.

A resource is one record (`resource.Resource`): its path, the models of question and answer, the
task that a worker runs, the lines of lists, its files. A file of this room holds each; `registry`
has them all. `jobs.Jobs` runs the questions of one resource and keeps the answers;
`routes/resource_routes.py` makes the routes of any. Begin with `designs.py`.
"""
