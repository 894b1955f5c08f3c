"""Dynamics of the arm: kinematics, inverse dynamics, motor torque, deflection and resonances."""
