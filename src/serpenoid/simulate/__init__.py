"""Forward simulation: one root per step (Even et al., Alg. 1)."""

from serpenoid.simulate.rollout import simulate_batch, simulate_joint_angles, simulate_vertices
from serpenoid.simulate.space import simulate_in_space

__all__ = ["simulate_batch", "simulate_in_space", "simulate_joint_angles", "simulate_vertices"]
