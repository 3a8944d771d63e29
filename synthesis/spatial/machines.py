"""All machines around spatial cams: a new one is its file and its name here."""

from __future__ import annotations

from synthesis.spatial.globoidal_indexer import GloboidalIndexer

AnyMachine = GloboidalIndexer
