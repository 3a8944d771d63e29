"""Spatial cams sized: law and dimension together, with a bound over all laws."""
