"""Files of measured profiles and surfaces: readers for each format, interpretation of the content, and writing."""
