"""What all requests and responses share.

In come the bytes of a request. `body` limits their size and reads them strictly as a model; what is
wrong with them is a list of violations (where, which value, which rule, what to write), which the
core finds (`synthesis.errors`) and `violations` puts on the wire.
Every error has a type (`errors`) and becomes a problem document (`problem`). `conditional` has tags
and ranges, `observe` logs and counts. Begin with `problem.py`.
"""
