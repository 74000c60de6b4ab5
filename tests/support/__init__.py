"""Helpers of the tests: inputs, studies, results, the command line and the browser."""
