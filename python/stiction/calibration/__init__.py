"""Calibration of interfaces: fit of mu0 and tau0 to friction tests, and predictions of friction from the fit."""
