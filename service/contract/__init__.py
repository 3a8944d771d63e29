"""What the OpenAPI document says beyond what FastAPI reads from the handlers, with its examples.

It stands below the routes: they take their words from here.
"""
