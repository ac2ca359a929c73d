"""Independent oracles: the paper's formulas by hand in NumPy/SciPy. Nothing here may import `serpenoid`.

`chain` (gait -> joint angles -> vertices), `integrator` (Algorithm 1 by a SciPy root), `search` (derivative-free
optimisation of the gait ellipse), `resistive_force` (closed formulas for long waves).
"""
