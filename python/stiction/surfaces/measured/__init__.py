"""Files of measured profiles and surfaces: a reader for each format, the interpretation of the content, and writing."""
