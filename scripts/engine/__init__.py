"""A release of MuJoCo answers here if it moves robots and environments as the last one did, to the bit.

python -m scripts.engine
"""
