"""The nonlinear program of a whole cycle, laid out and prepared."""
