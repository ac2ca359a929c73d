"""Forward simulation: invariants, order, closed formulas, the oracle, the right root, space."""
