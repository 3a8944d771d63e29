"""The cam as a solid: slabs with bore, keyway and hub. Needs the extra ``cad``."""
