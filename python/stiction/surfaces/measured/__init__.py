"""Files of measured profiles and surfaces: readers of each format, interpretation of the content, and writers."""
