"""Slow, simple, independent implementations that the library is compared with."""
