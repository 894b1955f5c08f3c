"""Names of joints, tendons and actuators in the MuJoCo model, by the name of a joint of the robot."""

motor_joint = "{}_motor".format
"""Name of the hinge that the motor of a joint turns."""
deflection_joint = "{}_deflection".format
"""Name of the hinge that is the elasticity of a joint."""
servo_actuator = "{}_servo".format
"""Name of the servo actuator of a joint."""
friction_actuator = "{}_friction".format
"""Name of the friction actuator of a joint."""
arm_friction_actuator = "{}_arm_friction".format
"""Name of the actuator that is the friction of a joint behind its elasticity."""
link_tendon = "{}_link_angle".format
"""Name of the tendon whose length is the angle of a link times the gear ratio."""
motor_tendon = "{}_motor_angle".format
"""Name of the tendon whose length is the angle of a motor that other axes turn too."""
