"""The cam as every file sees it: at which angles, where its points stand, in which columns."""
