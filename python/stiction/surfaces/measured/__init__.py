"""Files of measured profiles and height maps: readers for each format, interpretation of the content, and writers."""
