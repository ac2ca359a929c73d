"""Tracks cut into windows, and what a model predicts of each."""
