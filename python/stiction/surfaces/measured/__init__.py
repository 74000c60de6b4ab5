"""Files of measured profiles and surfaces: format readers, interpretation of the content, and writers."""
