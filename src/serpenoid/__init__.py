"""Optimal gaits for limbless robots and animals: simulate, optimise, play, measure, diagnose."""
