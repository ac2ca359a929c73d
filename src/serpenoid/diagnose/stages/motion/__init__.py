"""From shape to path: what floor, water and cameras' frame do."""
