"""Motor and current loop: what becomes of the torque that the servo commands."""
