"""What all requests and responses share.

In come the bytes of a request, over a `connection` with limits, in `places` that clients hold.
`body` limits their size and has them read where it holds up nobody; `validation` reads them
strictly as a model. What is wrong with them is a list of violations (where, which value, which
rule, what to write), which the core finds (`synthesis.errors`) and `violations` puts on the wire.
Every error has a type (`errors`) and becomes a problem document (`problem`). `conditional` has
tags, ranges and HEAD, `observe` logs and counts. Begin with `problem.py`.
"""
