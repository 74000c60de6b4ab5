"""`stiction app`: a page on this computer where two scans are dropped, and commands that compute what it shows."""
