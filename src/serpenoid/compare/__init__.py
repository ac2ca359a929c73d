"""Measured against simulated: resimulation, errors, calibration, performance ratios, cost of transport, report."""

from serpenoid.callable_room import make_callable

make_callable(__name__)
