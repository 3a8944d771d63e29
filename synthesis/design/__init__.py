"""Design: what is delivered, as it goes over the wire.

``design`` is the answer to a ``DesignSpec``: motion, size, extremes of all limits, and what is
proven. Files are made from it alone; ``Design.curve`` rebuilds the motion to the last bit.
``analysis`` is the answer about a cam that is given in full, ``cam_set`` that about several on one
shaft. ``identity`` gives ids: a hash of the question and the engine's number. Open ``design``.
"""
