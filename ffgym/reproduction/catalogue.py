"""All items in the order of the thesis."""

from ffgym.reproduction import lugre_one_axis, lugre_real, lugre_robot
from ffgym.reproduction.items import Item

ITEMS: tuple[Item, ...] = (*lugre_one_axis.ITEMS, *lugre_robot.ITEMS, *lugre_real.ITEMS)
"""Every figure and table of chapters 4 and 5 that has numbers or curves. Figures 4.1, 5.1 and 5.4 are diagrams."""
