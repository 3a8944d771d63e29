"""The six-bar shaper: crank, rocking or rotating slotted guide, coupler and ram (quick return).

In: a ShaperSpec with all lengths, or with some left free and a stroke and ratio wanted. Out: a
SixBarShaper. Open ``mechanism`` first: the loop equations and the crank's motion; ``report`` has
the answer's fields and finds dead centres and proven extremes over a turn. Free lengths: ``sizing``
is the search for the best and the explanation where there are none, ``design_space`` all shapers
that keep the limits, as a unit box, and the objectives.
"""

from synthesis.machines.linkages.shaper.report import SixBarShaper
from synthesis.machines.linkages.shaper.sizing import analyse_or_size_shaper
from synthesis.machines.linkages.shaper.spec import ShaperSpec

__all__ = ["ShaperSpec", "SixBarShaper", "analyse_or_size_shaper"]
