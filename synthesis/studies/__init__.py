"""Studies: questions about given cams and about several designs.

In: a spec, a design, measured points or a base spec with axes. Out: an answer of its own.
``analyse`` judges a cam that is given in full; ``cam_set`` designs the cams of one shaft;
``sensitivity`` says what each limit costs; ``measured`` reads the motion back from points of a
profile; ``sweeps`` makes many specs of one and finds the Pareto front of their designs (the service
solves them). All of them call ``pipeline.synthesise``; none has a solver of its own.
"""
