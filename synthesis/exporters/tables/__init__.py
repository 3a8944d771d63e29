"""Tables of numbers: CSV, JSON and plain text, of profiles, motions and responses."""
