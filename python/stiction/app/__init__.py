"""Browser app `stiction app`: a local server, and a page that runs stiction's commands."""
