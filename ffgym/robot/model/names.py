"""Names of the parts of a model: joints, actuators, tendons."""


def motor_joint(joint: str) -> str:
    """Name of the hinge that the motor turns."""
    return f"{joint}_motor"


def deflection_joint(joint: str) -> str:
    """Name of the hinge that is the elasticity."""
    return f"{joint}_deflection"


def servo_actuator(joint: str) -> str:
    """Name of the servo actuator."""
    return f"{joint}_servo"


def friction_actuator(joint: str) -> str:
    """Name of the friction actuator."""
    return f"{joint}_friction"


def motor_tendon(joint: str) -> str:
    """Name of the tendon whose length is the angle of a motor that other axes turn too."""
    return f"{joint}_motor_angle"


def spring_tendon(spring: str) -> str:
    """Name of the tendon that is a spring between links."""
    return f"{spring}_spring"
