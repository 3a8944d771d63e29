"""Answers as tables for a terminal, one kind a file."""
