"""Helpers of the tests for surfaces, studies, results, the command line and the browser."""
