"""Design: what is delivered, as it goes over the wire."""
