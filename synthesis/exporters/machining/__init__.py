"""Programs for machine tools: paths of cutters and wheels with a feed (ISO 6983, "G-code")."""
