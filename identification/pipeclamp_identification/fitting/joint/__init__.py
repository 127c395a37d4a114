"""What the joint fit of all parameters is made of.

Bounds and priors, the points that it starts from, the law's residuals there, and how sure the fitted parameters are.
The fit itself stands beside this room, in `least_squares`.
"""
