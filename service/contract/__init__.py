"""The OpenAPI document: texts and schemas beyond what FastAPI reads from handlers, and examples.

The routes import their descriptions from here. Begin with `documentation.py`.
"""
