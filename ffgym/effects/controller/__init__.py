"""What the machine's controller does otherwise than documented."""

from ffgym.effects.controller.servo_gains import ServoGains as ServoGains
