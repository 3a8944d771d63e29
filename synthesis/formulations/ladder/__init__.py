"""The ladder from closed form over cone programs to local optima, and the detours of some scenes.

`refine.search` is the way in: it takes the rungs one after the other, and none without need.
"""
