"""Symbolic mechanics: energy, momentum, kinematics, compiled evaluation."""
