"""All items in the order of the thesis."""

from ffgym.reproduction import (
    beyond,
    bsn_basis,
    bsn_fast,
    bsn_one_axis,
    bsn_real,
    bsn_robot,
    bsn_training,
    lugre_one_axis,
    lugre_real,
    lugre_robot,
)
from ffgym.reproduction.items import Item

CHAPTER_4 = (*lugre_one_axis.ITEMS, *lugre_robot.ITEMS, *lugre_real.ITEMS)
CHAPTER_5 = (
    *bsn_basis.ITEMS,
    *bsn_one_axis.ITEMS,
    *bsn_training.ITEMS,
    *bsn_robot.ITEMS,
    *bsn_real.ITEMS,
    *bsn_fast.ITEMS,
)
ITEMS: tuple[Item, ...] = (*CHAPTER_4, *CHAPTER_5, *beyond.ITEMS)
"""Every figure and table of chapters 4 and 5 that has numbers or curves. Figures 4.1, 5.1 and 5.4 are diagrams.
Two more items go beyond it."""
