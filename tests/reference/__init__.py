"""Slow, obvious, independent code that the library is held to. It shares nothing with it but the model's text."""
