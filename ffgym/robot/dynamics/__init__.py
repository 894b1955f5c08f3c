"""The arm as a rigid body: kinematics, inverse dynamics, motor torque, and what its elasticity does."""
