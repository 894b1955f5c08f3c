"""Chapters 4 to 6 of the thesis, simulated: its figures, tables and claims beside ours."""

from ffgym.reproduction.catalogue import ITEMS as ITEMS
from ffgym.reproduction.items import Item as Item
from ffgym.reproduction.items import chosen as chosen
from ffgym.reproduction.laboratory import SEED as SEED
from ffgym.reproduction.laboratory import Laboratory as Laboratory
from ffgym.reproduction.page import render_page as render_page
from ffgym.reproduction.reproduce import Reproduced as Reproduced
from ffgym.reproduction.reproduce import as_json as as_json
from ffgym.reproduction.reproduce import count as count
from ffgym.reproduction.reproduce import fingerprints as fingerprints
from ffgym.reproduction.reproduce import reproduce as reproduce
