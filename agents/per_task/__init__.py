"""Iterative learning: the answer of the robot to torque, corrections, and torques for given motions."""
