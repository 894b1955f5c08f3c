from .catalogue import PARTS as PARTS
from .part import Part as Part
from .part import entries as entries
from .place import Place as Place
