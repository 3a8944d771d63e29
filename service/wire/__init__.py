"""What every request and answer has in common: bodies read strictly, problems told, tags, parts.

All resources use it, so that they behave alike.
"""
