"""Recovery: from a solver's point to a cam, with its laws fixed and its size fitted to them.

In: laws and a size near the solution. Out: a ``Candidate``. Open ``candidate`` first. No cone
program is solved here: sizes follow in closed form (``closed_form``) or by enlarging the cam until
its nonconvex limits hold (``smooth_limits``).
"""
