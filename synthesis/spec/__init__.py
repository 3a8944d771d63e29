"""Specification: what is asked, as it comes over the wire, checked and placed on the cam."""
