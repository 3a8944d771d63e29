"""From laws to a cam: the size fitted to settled laws, the objective and limits measured on it.

No cone program of free laws is needed for that, only laws and sizes.
"""
