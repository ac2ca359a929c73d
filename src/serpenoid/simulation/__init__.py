"""Forward simulation: one root per step (Even et al., Alg. 1)."""

from serpenoid.simulation.rollout import simulate_batch, simulate_joint_angles, simulate_realised, simulate_vertices
from serpenoid.simulation.space import simulate_in_space

__all__ = ["simulate_batch", "simulate_in_space", "simulate_joint_angles", "simulate_realised", "simulate_vertices"]
