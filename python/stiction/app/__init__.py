"""Browser app `stiction app`: a local server, and a page on which users run commands of stiction."""
