"""Files of linkages, by kind and file name.

In: the answer about a linkage and a format's options. Out: bytes. ``linkage_file`` is the format,
and what animations of all kinds share; ``links`` are shapes of rigid links. ``shaper_files`` and
``arm_files`` list the files of a kind at their ends: a new one is a row there. ``shaper_motion``
samples the shaper for tables and for the spec of a cam, ``arm_shapes`` draws the arm.
"""

from __future__ import annotations

from synthesis.machines.linkages.files import arm_files, shaper_files
from synthesis.machines.linkages.files.linkage_file import LinkageFile

LINKAGE_FILES = {"six-bar-shapers": shaper_files.FILES, "palletising-arms": arm_files.FILES}

__all__ = ["LINKAGE_FILES", "LinkageFile"]
