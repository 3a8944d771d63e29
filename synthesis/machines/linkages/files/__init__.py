"""Files of linkages, by kind and file name.

In: the answer about a linkage and a format's options. Out: bytes. ``linkage_file`` is the format,
and what drawings and animations of all kinds share. ``shaper`` and ``arm`` list the files of a kind
at their ends: a new one is a row there.
"""

from __future__ import annotations

from synthesis.machines.linkages.files import arm, shaper
from synthesis.machines.linkages.files.linkage_file import LinkageFile

LINKAGE_FILES: dict[str, dict[str, LinkageFile]] = {
    kind: {each.name: each for each in files}
    for kind, files in (("six-bar-shapers", shaper.FILES), ("palletising-arms", arm.FILES))
}

__all__ = ["LINKAGE_FILES", "LinkageFile"]
