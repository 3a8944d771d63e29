"""Commands that are more than a call of the core, one a file."""
