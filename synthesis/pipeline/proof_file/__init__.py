"""Proof files: what a design claims, as a file that anyone can check without this program.

In: a design. Out: a plain dictionary, the format of ``docs/proof.md``: the question, the cam, and
every claim with its witness or with why the format does not cover it. ``checker/check.py`` reads
it; it shares nothing with this room, and a claim is called proven here only if it accepts it.

Open ``claims.py`` first; ``multipliers.py`` writes those of a cone program for the checker.
``rounds.py`` writes witnesses of bounds that curvature raises, ``arms.py`` those of an arm's size,
by the linear programs of ``program.py``; ``sizes.py`` what every law keeps of a slide's size, and
``swinging_faces.py`` the size of a swinging face under given laws.
"""

from __future__ import annotations

from typing import Any

from synthesis.design.design import Design

__all__ = ["proof"]


def proof(design: Design) -> dict[str, Any]:
    """The proof file of a design: numbers, texts and lists, ready for JSON.

    Its bound may be a little below the design's: multipliers are found again, and rounded. Takes as
    long as the design's own search, or less.
    """
    from synthesis.pipeline.proof_file.claims import proof_file

    return proof_file(design)
