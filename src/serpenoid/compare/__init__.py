"""Measured against simulated: resimulation, errors, calibration, performance ratios, cost of transport, report."""
