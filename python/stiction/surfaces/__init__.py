"""Measured and generated profiles and height maps: reading, preparation, spectra and roughness."""
