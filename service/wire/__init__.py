"""What all requests and responses share.

In come the bytes of a request. `body` reads them strictly as a model; what is wrong with them is a
list of violations (`violations`: where, which value, which rule, what to do; `schema_walk` finds
the names that are allowed there). Every error has a type (`errors`) and becomes a problem document
(`problem`). Middleware refuses bodies that are too large (`body_limit`), tags what is compressed
(`etag`), cuts out ranges (`ranges`), logs and counts (`observe`, `metrics`); `pages` has the
cursors of lists. Begin with `problem.py`.
"""
