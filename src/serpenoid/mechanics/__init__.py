"""Symbols in, symbols out: chain kinematics, dissipation, step energy, geometric momentum; and their compilation."""
