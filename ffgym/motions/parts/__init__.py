"""What a motion file is made of: one small table for each part of the motion."""

from ffgym.motions.parts.catalogue import PARTS as PARTS
from ffgym.motions.parts.part import Part as Part
from ffgym.motions.parts.part import entries as entries
from ffgym.motions.parts.place import Place as Place
