"""Chapters 4 to 6 of the thesis, simulated: its figures, tables and claims beside ours."""

from scripts.thesis.catalogue import ITEMS as ITEMS
from scripts.thesis.catalogue import Item as Item
from scripts.thesis.catalogue import Reproduced as Reproduced
from scripts.thesis.catalogue import as_json as as_json
from scripts.thesis.catalogue import chosen as chosen
from scripts.thesis.catalogue import count as count
from scripts.thesis.catalogue import fingerprints as fingerprints
from scripts.thesis.catalogue import render_page as render_page
from scripts.thesis.catalogue import reproduce as reproduce
from scripts.thesis.studies import SEED as SEED
from scripts.thesis.studies import ThesisStudies as ThesisStudies
