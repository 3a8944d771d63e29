"""State of a solve: incumbent, bound, mesh, and what each stage cost. Immutable.

Open ``solve_state.py``.
"""
