"""Entries of a robot description as TOML text, for tests that write their own."""


def entry(path, value, unit, side=None, *, origin="chosen", source="test"):
    """One table of a description."""
    side_line = f"side = '{side}'\n" if side else ""
    return f"[{path}]\nvalue = {value}\nunit = {unit!r}\n{side_line}origin = '{origin}'\nsource = '{source}'\n"


def small_motors(n):
    """Motors of a small arm: rotors, friction, servos and resolvers of `n` equal ones, motor side."""
    numbers = [
        ("drive.rotor_inertia", 5e-4, "kg m^2"),
        ("drive.peak_torque", 5.0, "N m"),
        ("friction.coulomb", 0.1, "N m"),
        ("friction.static", 0.12, "N m"),
        ("friction.viscous", 0.002, "N m s/rad"),
        ("friction.stribeck_velocity", 0.5, "rad/s"),
        ("friction.bristle_stiffness", 20.0, "N m/rad"),
        ("friction.bristle_damping", 0.05, "N m s/rad"),
        ("servo.position_gain", 2.0, "N m/rad"),
        ("servo.velocity_gain", 0.06, "N m s/rad"),
        ("servo.integral_gain", 10.0, "N m/(rad s)"),
    ]
    text = "".join(entry(path, [value] * n, unit, "motor") for path, value, unit in numbers)
    return text + entry("sensors.encoder_bits", 16, "bit/turn", "motor") + entry("simulation.physics_dt", 0.0005, "s")
