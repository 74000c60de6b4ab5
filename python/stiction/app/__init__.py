"""Browser app `stiction app`: a local server and page that run the commands of stiction."""
