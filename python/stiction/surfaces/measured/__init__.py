"""Files of measured profiles and surfaces: a reader for each format, what is made of it, writing."""
