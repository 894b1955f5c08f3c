"""A second engine: rigid bodies by Pinocchio, and motors, gearboxes, springs and friction by equations of our own."""
