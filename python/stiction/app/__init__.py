"""Browser app `stiction app`: a local server, and a page that runs commands of stiction."""
