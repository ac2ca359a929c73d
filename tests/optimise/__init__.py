"""The gait NLP: derivatives, certificates, constraints, global search, many starts."""
