"""Whole studies: sweeps, sets of gaits, the paper's protocol, what a diagnosis is worth, each verb as a function."""
