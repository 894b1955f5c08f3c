"""All items in the order of the thesis."""

from scripts.thesis import (
    beyond,
    bsn_basis,
    bsn_fast,
    bsn_one_axis,
    bsn_real,
    bsn_robot,
    bsn_training,
    lugre_identified,
    lugre_one_axis,
    lugre_real,
    lugre_robot,
    narx,
    narx_extended,
    reidentified,
)
from scripts.thesis.items import Item

CHAPTER_4 = (*lugre_one_axis.ITEMS, *lugre_robot.ITEMS, *lugre_real.ITEMS)
CHAPTER_5 = (
    *bsn_basis.ITEMS,
    *bsn_one_axis.ITEMS,
    *bsn_training.ITEMS,
    *bsn_robot.ITEMS,
    *bsn_real.ITEMS,
    *bsn_fast.ITEMS,
)
CHAPTER_6 = (*lugre_identified.ITEMS, *narx.ITEMS)
ITEMS: tuple[Item, ...] = (*CHAPTER_4, *CHAPTER_5, *CHAPTER_6, *beyond.ITEMS, *narx_extended.ITEMS, *reidentified.ITEMS)
"""Every figure and table of chapters 4 to 6 that has numbers or curves; 4.1, 5.1, 5.4, 6.8 and 6.9 are diagrams. More
items go beyond it."""
