"""Gait optimisation: the whole-cycle NLP, its limits, IPOPT, certificates and many starts."""
