from .servo_gains import ServoGains as ServoGains
