"""The ladder from closed form over cone programs to IPOPT, and the detours that some scenes need.

`refine.search` is the way in: it takes the rungs one after the other, and none without need.
"""
