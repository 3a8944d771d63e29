"""Answers as tables on a terminal, one kind a file."""
