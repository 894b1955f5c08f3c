"""Parts of elastic feed-forward: the lead of the motors, friction between samples, the torque that is there."""
