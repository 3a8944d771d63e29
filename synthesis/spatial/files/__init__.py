"""Files made from a spatial cam: one format a file. A new one is a file and its name here."""
