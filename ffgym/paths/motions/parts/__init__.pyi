from .catalogue import PARTS as PARTS
from .part import Part as Part
from .part import Place as Place
from .part import entries as entries
